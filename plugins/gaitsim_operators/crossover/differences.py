"""Differences between parents, for crossovers that mix real genes."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, RealSpace


def parent_differences(mothers: Genomes, fathers: Genomes, space: RealSpace) -> NDArray[np.float64]:
    """Return father minus mother, (pairs, genes); periodic genes take the shorter way round."""
    direct: NDArray[np.float64] = fathers - mothers
    if space.periodic is None:
        return direct
    shorter = direct - space.width * np.rint(direct / space.width)
    return np.where(space.periodic, shorter, direct)
