"""Principal axes of a covariance matrix, with identical bits on every machine."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

MOST_SWEEPS = 30  # about eight are needed
NEGLIGIBLE = 1e-14  # covariance, as a share of the geometric mean of the two variances


@njit(nogil=True, cache=True, error_model="numpy")
def principal_axes(
    covariance: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the variances along the axes, (genes,), and the axes as rows, (genes, genes).

    Uses cyclic Jacobi rotations (Demmel and Veselić 1992, "Jacobi's method is more accurate than
    QR"). LAPACK's results depend on the processor and the number of threads, and its threads wait
    for each other on a busy machine: 48 genes take 0.3 ms with one thread and 50 ms with two,
    compared with 1 ms here.

    Args:
        covariance: symmetric, positive definite matrix, (genes, genes).
    """
    genes = len(covariance)
    matrix, axes = covariance.copy(), np.eye(genes)
    for _ in range(MOST_SWEEPS):
        rotated = False
        for p in range(genes - 1):
            for q in range(p + 1, genes):
                off = matrix[p, q]
                if abs(off) <= NEGLIGIBLE * np.sqrt(abs(matrix[p, p] * matrix[q, q])):
                    continue
                rotated = True
                ratio = (matrix[q, q] - matrix[p, p]) / (2 * off)
                tangent = 1 / (abs(ratio) + np.sqrt(ratio * ratio + 1))
                if ratio < 0:
                    tangent = -tangent
                cosine = 1 / np.sqrt(tangent * tangent + 1)
                sine = tangent * cosine
                variances = matrix[p, p] - tangent * off, matrix[q, q] + tangent * off
                for k in range(genes):
                    a, b = matrix[p, k], matrix[q, k]
                    matrix[p, k] = cosine * a - sine * b
                    matrix[q, k] = sine * a + cosine * b
                    a, b = axes[p, k], axes[q, k]
                    axes[p, k] = cosine * a - sine * b
                    axes[q, k] = sine * a + cosine * b
                for k in range(genes):
                    matrix[k, p], matrix[k, q] = matrix[p, k], matrix[q, k]
                matrix[p, p], matrix[q, q] = variances
                matrix[p, q] = matrix[q, p] = 0.0
        if not rotated:
            break
    return np.diag(matrix).copy(), axes
