"""The roulette wheel: a slot for each individual, as wide as its weight."""

import numpy as np
from numpy.typing import NDArray


def spin(weights: NDArray[np.float64], pairs: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw positions in proportion to weights, with replacement.

    Args:
        weights: (population,), none negative, at least one positive.
        pairs: number of pairs to draw.
        rng: the only source of randomness.

    Returns:
        Positions of mothers and fathers, (pairs, 2); never one of weight 0.
    """
    edges = np.cumsum(weights)
    # A draw is below 1, and so its product below the last edge, rounded or not.
    positions: NDArray[np.intp] = np.searchsorted(
        edges, rng.random((pairs, 2)) * edges[-1], side="right"
    )
    return positions
