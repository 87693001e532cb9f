"""Roulette selection: probabilities in proportion to the score above the worst."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection
from gaitsim_operators.selection.wheel import spin


class Roulette(Selection):
    """Draws parents in proportion to their score above the worst finite score.

    Holland 1975. The shift allows negative scores; the worst never breeds unless all scores are
    equal.
    """

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return the indices of pairs of parents, (pairs, 2), given scores, (population,).

        An individual with a score of −inf is never drawn. If all finite scores are equal, the
        individuals with these scores are equally likely; without finite scores, all individuals
        are.
        """
        return spin(_weights(scores), pairs, rng)


def _weights(scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights of scores, (population,), from 0 to 1, at least one above 0."""
    finite = np.isfinite(scores)
    if not finite.any():
        return np.ones(len(scores))
    # Scores are halved so that even the widest range of finite scores does not overflow.
    halves = np.where(finite, scores, scores[finite].min()) / 2
    weights: NDArray[np.float64] = halves - halves.min()
    top = weights.max()
    return weights / top if top > 0 else finite.astype(np.float64)
