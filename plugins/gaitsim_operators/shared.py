"""Random draws and a check of genome spaces, shared by several kinds of operators."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GenomeSpace, PluginError, RealSpace


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


def real_space(space: GenomeSpace) -> RealSpace:
    """Return the space with the type `RealSpace`."""
    if not isinstance(space, RealSpace):
        raise PluginError(
            f"this operator does not support genomes of the kind {space.name!r}",
            allowed="genomes of the kind 'real' (real numbers)",
            remedy="choose an operator that supports these genomes",
        )
    return space
