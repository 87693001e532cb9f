"""Rank selection: probabilities in proportion to rank."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection, option
from gaitsim_operators.selection.ranking import best_first
from gaitsim_operators.selection.wheel import spin


class Rank(Selection):
    """Draws parents with a probability that falls linearly from the best to the worst.

    Baker 1985: the best has `pressure` times the mean probability, the worst 2 − `pressure` times,
    regardless of the distance between their scores.
    """

    pressure: float = option(
        1.5,
        "probability of choosing the best individual, relative to the mean probability; "
        "1 ignores the scores",
        ge=1,
        le=2,
    )

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return the indices of pairs of parents, (pairs, 2), given scores, (population,)."""
        if len(scores) == 1:
            return np.zeros((pairs, 2), dtype=np.intp)
        weights = np.linspace(self.pressure, 2 - self.pressure, len(scores))
        return best_first(scores)[spin(weights, pairs, rng)]
