"""The difference between parents, for crossovers that mix real genes."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, RealSpace


def gap(mothers: Genomes, fathers: Genomes, space: RealSpace) -> NDArray[np.float64]:
    """Return father minus mother, (pairs, genes); periodic genes take the shorter way round."""
    way: NDArray[np.float64] = fathers - mothers
    if space.periodic is None:
        return way
    return np.where(space.periodic, way - space.width * np.rint(way / space.width), way)
