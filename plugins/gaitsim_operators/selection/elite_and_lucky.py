"""Elite-and-lucky selection: the best survive, and a few others by luck."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection, option
from gaitsim_operators.selection.pairing import random_pairs
from gaitsim_operators.selection.ranking import best_first


class EliteAndLucky(Selection):
    """The best and some random others survive; parents are two different survivors.

    The lucky ones keep genes in the pool that the elite has lost. A population
    smaller than both numbers together survives whole.
    """

    elite: int = option(16, "how many of the best survive", ge=1, le=100_000)
    lucky: int = option(4, "how many of the rest survive by luck", ge=0, le=100_000)

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Scores (population,) -> pairs of survivors, uniformly drawn, (pairs, 2)."""
        order = best_first(scores)
        lucky = rng.permutation(order[self.elite :])[: self.lucky]
        return random_pairs(np.concatenate((order[: self.elite], lucky)), pairs, rng)
