"""Truncation selection: the best share breeds."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection, option
from gaitsim_operators.selection.pairing import random_pairs
from gaitsim_operators.selection.ranking import best_first


class Truncation(Selection):
    """Keeps the best share of the population; parents are two different survivors.

    Mühlenbein and Schlierkamp-Voosen 1993. At least two individuals survive, unless the population
    has only one.
    """

    share: float = option(0.2, "share of the population that breeds", gt=0, le=1)

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return indices of random pairs of survivors, (pairs, 2), given scores, (population,)."""
        survivors = max(2, round(self.share * len(scores)))
        return random_pairs(best_first(scores)[:survivors], pairs, rng)
