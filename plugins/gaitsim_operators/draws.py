"""Random draws shared by several kinds of operators."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def distinct_pairs(
    count: int, shape: int | tuple[int, ...], rng: np.random.Generator
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Draw pairs of distinct numbers below `count`; all ordered pairs are equally likely.

    Args:
        count: exclusive upper bound of the numbers, at least 2.
        shape: shape of each of the two results.
        rng: source of randomness.

    Returns:
        The first numbers and the second numbers, each of `shape`.
    """
    # A single draw for both numbers takes half the time of two.
    first, second = np.divmod(rng.integers(0, count * (count - 1), shape), count - 1)
    second += second >= first
    return first, second
