"""Random pairs of different survivors."""

import numpy as np
from numpy.typing import NDArray

from gaitsim_operators.draws import distinct_pairs


def random_pairs(
    survivors: NDArray[np.intp], pairs: int, rng: np.random.Generator
) -> NDArray[np.intp]:
    """Draw pairs of different survivors; all ordered pairs are equally likely.

    Args:
        survivors: indices of the survivors, (survivors,); a single one is paired with itself.
        pairs: number of pairs to draw.
        rng: the only source of randomness.

    Returns:
        Indices of mothers and fathers, (pairs, 2).
    """
    if len(survivors) == 1:
        return np.full((pairs, 2), survivors[0])
    positions = np.stack(distinct_pairs(len(survivors), pairs, rng), axis=1)
    chosen: NDArray[np.intp] = survivors[positions]
    return chosen
