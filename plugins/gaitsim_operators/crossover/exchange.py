"""Children that have each gene from one parent or the other."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes


def exchange(
    mothers: Genomes, fathers: Genomes, swapped: NDArray[np.bool_], children: int
) -> NDArray[Any]:
    """Return first children, mothers with swapped genes, and second ones, fathers with them.

    Args:
        mothers: (pairs, genes).
        fathers: (pairs, genes).
        swapped: genes that the parents exchange, broadcast to (pairs, genes).
        children: 1 or 2 of a pair.

    Returns:
        All first children, then all second ones, (pairs × children, genes).
    """
    first = np.where(swapped, fathers, mothers)
    if children == 1:
        return first
    return np.concatenate((first, np.where(swapped, mothers, fathers)))
