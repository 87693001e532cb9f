"""Linear algebra with small matrices, in a fixed order of operations; compiled code.

The results of LAPACK and BLAS depend on the processor and the number of threads.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MOST_SWEEPS = 30  # about eight are needed
NEGLIGIBLE = 1e-14  # covariance, as a share of the geometric mean of the two variances


@njit(nogil=True, cache=True, error_model="numpy")
def multiply(a: Floats, b: Floats, out: Floats) -> None:
    """Add the products of matrices (n, i, k) and (n, k, j) to `out`, (n, i, j), in order of k."""
    # The innermost loop is independent sums, so it vectorises without a change of their order.
    for n in range(a.shape[0]):
        for i in range(a.shape[1]):
            for k in range(a.shape[2]):
                factor = a[n, i, k]
                for j in range(b.shape[2]):
                    out[n, i, j] += factor * b[n, k, j]


@njit(nogil=True, cache=True, error_model="numpy")
def cholesky(matrix: Floats) -> Floats:
    """Return the lower triangle L with L Lᵀ equal to a positive definite matrix, (n, n)."""
    lower = np.zeros_like(matrix)
    for i in range(len(matrix)):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            lower[i, j] = np.sqrt(rest) if i == j else rest / lower[j, j]
    return lower


@njit(nogil=True, cache=True, error_model="numpy")
def solve(matrices: Floats, vectors: Floats) -> None:
    """Replace vectors b, (n, size), by the solutions x of A x = b; A is positive definite.

    Args:
        matrices: the matrices A, (n, size, size).
        vectors: the vectors b, and the output.
    """
    size = matrices.shape[1]
    for n in range(len(matrices)):
        lower, x = cholesky(matrices[n]), vectors[n]
        for i in range(size):
            for k in range(i):
                x[i] -= lower[i, k] * x[k]
            x[i] /= lower[i, i]
        for i in range(size - 1, -1, -1):
            for k in range(i + 1, size):
                x[i] -= lower[k, i] * x[k]
            x[i] /= lower[i, i]


@njit(nogil=True, cache=True, error_model="numpy")
def substitute(lower: Floats, right: Floats) -> Floats:
    """Return the solution X, (n, columns), of L X = right by forward substitution."""
    solution = right.copy()
    for i in range(len(lower)):
        for k in range(i):
            for j in range(right.shape[1]):
                solution[i, j] -= lower[i, k] * solution[k, j]
        for j in range(right.shape[1]):
            solution[i, j] /= lower[i, i]
    return solution


@njit(nogil=True, cache=True, error_model="numpy")
def diagonalise(matrix: Floats, axes: Floats) -> None:
    """Turn the axes, rows of (genes, genes), to those of a covariance, which becomes diagonal.

    Uses cyclic Jacobi rotations (Demmel and Veselić 1992, "Jacobi's method is more accurate than
    QR"). LAPACK's results depend on the processor and the number of threads, and its threads wait
    for each other on a busy machine: 48 genes take 0.3 ms with one thread and 50 ms with two,
    compared with 1 ms here.

    Args:
        matrix: symmetric, positive definite matrix, (genes, genes), which is changed.
        axes: the identity, (genes, genes), which is changed.
    """
    genes = len(matrix)
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
