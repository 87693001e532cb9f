"""Draws that more than one kind of operator needs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def two_different(
    count: int, shape: int | tuple[int, ...], rng: np.random.Generator
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Draw two different numbers below `count`, at least 2, each ordered pair equally likely.

    Returns:
        The first ones and the second ones, each of `shape`.
    """
    # One draw gives both numbers: two draws take twice the time.
    first, second = np.divmod(rng.integers(0, count * (count - 1), shape), count - 1)
    second += second >= first
    return first, second
