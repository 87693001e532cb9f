"""Arithmetic with the same bits on every 64-bit processor.

The elementary functions of NumPy and of C libraries, products of matrices and normal draws give
other last bits on another processor, since they choose their instructions by it. No library
promises otherwise. These functions use IEEE 754 additions, products, quotients and square roots
alone, in a fixed order, so everything that decides a result takes them from here.

NumPy's elementwise `+ − × ÷`, `sqrt`, comparisons, sums, means and sorting are portable, too.
`np.einsum`, `np.interp`, `Generator.uniform` and powers are not: compilers may fuse a product and a
sum (on ARM), or call the C library.

Functions of numbers accept arrays of any shape and return float64. Errors are largest errors found
against mpmath, in units in the last place (ulp); zeros, infinities and NaN follow IEEE 754.
"""

import math
from collections import Counter
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.portable import scalar

Floats = NDArray[np.float64]

FEW = 1000
"""How many numbers a function maps in plain Python, at 5 to 50 µs each, before it compiles, which
takes up to half a second on a new machine. The bits are the same."""
_counts: Counter[str] = Counter()


def exp(x: ArrayLike) -> Floats:
    """Return the exponential; error below 0.7 ulp."""
    return _mapped("exp", x)


def log(x: ArrayLike) -> Floats:
    """Return the natural logarithm; error below 0.51 ulp."""
    return _mapped("log", x)


def power(x: ArrayLike, y: ArrayLike) -> Floats:
    """Return xʸ; error below 0.7 ulp."""
    return _mapped("power", x, y)


def sin(x: ArrayLike) -> Floats:
    """Return the sine; error below 0.8 ulp."""
    return _of_any_angle("sin", x)


def cos(x: ArrayLike) -> Floats:
    """Return the cosine; error below 0.8 ulp."""
    return _of_any_angle("cos", x)


def tan(x: ArrayLike) -> Floats:
    """Return the tangent; error below 1 ulp."""
    return _of_any_angle("tan", x)


def tanh(x: ArrayLike) -> Floats:
    """Return the hyperbolic tangent; error below 0.8 ulp."""
    return _mapped("tanh", x)


def arctan2(y: ArrayLike, x: ArrayLike) -> Floats:
    """Return the angle of points (x, y), −π to π; error below 0.7 ulp."""
    return _mapped("arctan2", y, x)


def arctan(x: ArrayLike) -> Floats:
    """Return the arc tangent; error below 0.7 ulp."""
    return _mapped("arctan", x)


def arcsin(x: ArrayLike) -> Floats:
    """Return the arc sine, NaN for |x| > 1; error below 2 ulp."""
    return _mapped("arcsin", x)


def arccos(x: ArrayLike) -> Floats:
    """Return the arc cosine, NaN for |x| > 1; error below 2 ulp."""
    return _mapped("arccos", x)


def norm(values: ArrayLike) -> Floats:
    """Return the Euclidean length along the last axis; squares may overflow."""
    length: Floats = np.sqrt(np.square(values, dtype=np.float64).sum(axis=-1))
    return length


def distances(one: Floats, other: Floats) -> Floats:
    """Return the distances of points (n, axes) and (m, axes), (n, m)."""
    squares = np.zeros((len(one), len(other)))
    for axis in range(one.shape[1]):
        squares += np.square(one[:, None, axis] - other[:, axis])
    return np.sqrt(squares)


def matmul(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the products of matrices (…, i, k) and (…, k, j), summed in order of k.

    Leading axes broadcast. The product of (30, 48) and (48, 48) takes 28 µs, as with `np.einsum`;
    BLAS takes 5 µs (one core of an AMD Zen 4).

    Raises:
        ValueError: the shapes do not fit.
    """
    from gaitsim.portable.linear import multiply

    # Copies, in C order and writable, so that the kernel is compiled for one kind of array.
    first, second = np.array(a, np.float64, order="C"), np.array(b, np.float64, order="C")
    if first.ndim < 2 or second.ndim < 2 or first.shape[-1] != second.shape[-2]:
        raise ValueError(f"cannot multiply matrices of shapes {first.shape} and {second.shape}")
    if first.ndim == second.ndim == 2:
        product = np.zeros((len(first), second.shape[1]))
        multiply(first[None], second[None], product[None])
        return product
    leading = np.broadcast_shapes(first.shape[:-2], second.shape[:-2])
    out = np.zeros((*leading, first.shape[-2], second.shape[-1]))
    stacks = (
        np.ascontiguousarray(np.broadcast_to(one, (*leading, *one.shape[-2:])))
        for one in (first, second)
    )
    count = math.prod(leading)
    multiply(*(one.reshape(count, *one.shape[-2:]) for one in (*stacks, out)))
    return out


def principal_axes(covariance: Floats) -> tuple[Floats, Floats]:
    """Return the variances along the axes of a covariance matrix, and its axes as rows.

    Args:
        covariance: symmetric, positive definite matrix, (genes, genes).

    Returns:
        The eigenvalues, (genes,), in no particular order, and the eigenvectors, (genes, genes).
    """
    from gaitsim.portable.linear import diagonalise

    matrix, axes = np.array(covariance, np.float64, order="C"), np.eye(len(covariance))
    diagonalise(matrix, axes)
    return np.diag(matrix).copy(), axes


def cholesky(matrix: Floats) -> Floats:
    """Return the lower triangle L, (n, n), of a positive definite matrix L Lᵀ, (n, n).

    A matrix that is not positive definite gives NaN.
    """
    from gaitsim.portable.linear import cholesky as triangle

    lower: Floats = triangle(np.ascontiguousarray(matrix, np.float64))
    return lower


def solve(matrices: Floats, vectors: Floats) -> Floats:
    """Return x, (…, n), with A x = b for positive definite A, (…, n, n), and b, (…, n).

    A matrix that is not positive definite gives NaN.
    """
    from gaitsim.portable.linear import solve as replace

    size = matrices.shape[-1]
    solutions = np.array(vectors, np.float64, order="C")
    count = math.prod(solutions.shape[:-1])
    stack = np.ascontiguousarray(matrices, np.float64).reshape(count, size, size)
    replace(stack, solutions.reshape(count, size))
    return solutions


def solve_triangular(lower: Floats, right: Floats) -> Floats:
    """Return X, (n, columns), with L X = right, for a lower triangle L, (n, n)."""
    from gaitsim.portable.linear import substitute

    solution: Floats = substitute(
        np.ascontiguousarray(lower, np.float64), np.ascontiguousarray(right, np.float64)
    )
    return solution


def standard_normal(rng: np.random.Generator, size: int | tuple[int, ...]) -> Floats:
    """Draw from the standard normal distribution, as `rng.standard_normal` does.

    Args:
        rng: a generator of 64-bit numbers, such as that of `np.random.default_rng`.
        size: shape of the result.

    Raises:
        ValueError: the generator's numbers have 32 bits.
    """
    from gaitsim.portable.normal import fill, strips

    out = np.empty(size)
    flat = out.reshape(-1)
    source, state = rng.bit_generator, rng.bit_generator.state
    if isinstance(source, np.random.MT19937):
        raise ValueError("MT19937 gives numbers of 32 bits; use np.random.default_rng")
    numbers = len(flat) + len(flat) // 16 + 64  # 1.02 numbers a draw on average
    while True:
        used = fill(source.random_raw(numbers), *strips(), flat)
        source.state = state
        if used >= 0:
            # Leave the generator where NumPy would.
            source.random_raw(used, output=False)
            return out
        numbers *= 2


def binomial(rng: np.random.Generator, trials: int, probability: float) -> int:
    """Draw the number of successes in trials, as `rng.binomial` does."""
    from gaitsim.portable.binomial_draws import draw

    return draw(rng, trials, probability)


def uniform(
    rng: np.random.Generator, low: ArrayLike, high: ArrayLike, size: int | tuple[int, ...]
) -> Floats:
    """Draw from the uniform distribution between `low` and `high`, as `rng.uniform` does."""
    bottom = np.asarray(low, np.float64)
    drawn: Floats = bottom + (np.asarray(high, np.float64) - bottom) * rng.random(size)
    return drawn


def _mapped(name: str, *arguments: ArrayLike) -> Floats:
    """Apply a function of `scalar` to each number; a scalar gives a scalar."""
    arrays = [np.asarray(one, np.float64) for one in arguments]
    if not any(one.ndim for one in arrays):
        # Plain Python gives the same bits, without loading or compiling the loop.
        with np.errstate(all="ignore"):
            number: Any = np.float64(getattr(scalar, name)(*map(float, arrays)))
        return np.asarray(number)[()]
    # The result has the memory layout of NumPy's, since the order of sums over it depends on that.
    # `itviews` are the arrays broadcast, in the order of that layout.
    flags: Any = [["readonly"]] * len(arrays) + [["writeonly", "allocate"]]
    iterator = np.nditer([*arrays, None], ["zerosize_ok"], flags)
    *inputs, flat = iterator.itviews
    parts = [np.ascontiguousarray(one).reshape(-1) for one in inputs]
    _counts[name] += flat.size
    if _counts[name] > FEW:
        from gaitsim.portable.compiled import loop

        loop(name)(*parts, flat.reshape(-1))
    else:
        with np.errstate(all="ignore"):
            flat[...] = np.reshape(
                [*map(getattr(scalar, name), *(part.tolist() for part in parts))], flat.shape
            )
    out: Floats = iterator.operands[-1]
    return out


def _of_any_angle(name: str, x: ArrayLike) -> Floats:
    """Apply a trigonometric function to each angle, rad, even if it is large."""
    angles = np.asarray(x, np.float64)
    out = np.asarray(_mapped(name, angles))
    large = np.abs(angles) > scalar.MODERATE
    if large.any():
        large &= np.isfinite(angles)
        out[large] = [_of_large_angle(name, angle) for angle in angles[large].tolist()]
    found: Floats = out[()]
    return found


def _of_large_angle(name: str, angle: float) -> Any:
    """Return the sine, cosine or tangent of a large angle, rad, by exact division by π/2."""
    numerator, denominator = angle.as_integer_ratio()
    quarters, rest = divmod(numerator * 2 * _PRECISION, denominator * _pi())
    # The rest of the division, in quarter turns; above π/4 it counts back from the next.
    half = denominator * _pi() // 2
    quarters, rest = (quarters + 1, rest - 2 * half) if rest > half else (quarters, rest)
    high = rest / (2 * denominator * _PRECISION)
    top, bottom = high.as_integer_ratio()
    low = (rest * bottom - top * 2 * denominator * _PRECISION) / (
        2 * denominator * _PRECISION * bottom
    )
    function = scalar.tan_of if name == "tan" else scalar.sin_of
    return function((quarters + (name == "cos")) & 3, high, low)


_PRECISION = 1 << 1300


@cache
def _pi() -> int:
    """Return π · 2¹³⁰⁰ (Machin 1706: π/4 = 4 arctan 1/5 − arctan 1/239)."""

    def arctan_inverse(x: int) -> int:
        total, power, n = 0, _PRECISION * 2**64 // x, 1
        while power:
            total += power // n if n % 4 == 1 else -(power // n)
            power //= x * x
            n += 2
        return total

    return 4 * (4 * arctan_inverse(5) - arctan_inverse(239)) >> 64
