"""Roulette selection: in proportion to fitness."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection
from gaitsim_operators.selection.wheel import spin


class Roulette(Selection):
    """Each parent is drawn in proportion to its score above the worst finite one.

    Holland 1975; the shift makes negative scores possible, and the worst never
    breeds unless all scores are equal.
    """

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Scores (population,) -> pairs, (pairs, 2).

        A score of −inf has no chance; where all finite scores are equal, those are
        equally likely, and where none is finite, all individuals are.
        """
        return spin(_weights(scores), pairs, rng)


def _weights(scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Scores (population,) -> weights from 0 to 1, at least one above 0, (population,)."""
    finite = np.isfinite(scores)
    if not finite.any():
        return np.ones(len(scores))
    # Half of each, so that the widest range of finite scores is finite, too.
    halves = np.where(finite, scores, scores[finite].min()) / 2
    weights: NDArray[np.float64] = halves - halves.min()
    top = weights.max()
    return weights / top if top > 0 else finite.astype(np.float64)
