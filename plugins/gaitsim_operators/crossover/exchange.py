"""Exchange of genes between parents, and cuts of genomes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes


def after_cuts(cuts: NDArray[np.integer[Any]], genes: int) -> NDArray[np.bool_]:
    """Return whether each gene, (pairs, genes), is at or after its pair's cut, (pairs, 1)."""
    narrow = np.min_scalar_type(genes)  # three times as fast as 64-bit integers
    return np.arange(genes, dtype=narrow) >= cuts.astype(narrow)


def exchange(
    mothers: Genomes, fathers: Genomes, swapped: NDArray[np.bool_], children: int
) -> NDArray[Any]:
    """Return copies of the mothers, then of the fathers, after exchanging some of their genes.

    Args:
        mothers: genomes, (pairs, genes).
        fathers: genomes, (pairs, genes).
        swapped: whether parents exchange each gene, broadcast to (pairs, genes).
        children: number of children per pair, 1 or 2.

    Returns:
        All first children, then all second children, (pairs × children, genes).
    """
    crossed = np.stack((mothers, fathers)[:children])
    # Flip the bits that differ: ten times as fast as np.where for genomes of bits.
    unsigned = f"u{crossed.itemsize}"
    bits = crossed.view(unsigned)
    bits ^= (mothers.view(unsigned) ^ fathers.view(unsigned)) * swapped
    return crossed.reshape(-1, mothers.shape[1])
