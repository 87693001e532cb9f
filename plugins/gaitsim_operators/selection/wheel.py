"""The roulette wheel, which draws individuals in proportion to their weights."""

import numpy as np
from numpy.typing import NDArray


def spin(weights: NDArray[np.float64], pairs: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw positions in proportion to weights, with replacement.

    Args:
        weights: weights, (population,), not negative, at least one positive.
        pairs: number of pairs to draw.
        rng: the only source of randomness.

    Returns:
        Positions of mothers and fathers, (pairs, 2), all with positive weights.
    """
    edges = np.cumsum(weights)
    # Draws are below 1, so their products are below the last edge even after rounding.
    positions: NDArray[np.intp] = np.searchsorted(
        edges, rng.random((pairs, 2)) * edges[-1], side="right"
    )
    return positions
