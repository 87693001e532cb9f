"""Elite-and-lucky selection: the best survive, and a few others at random."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection, option
from gaitsim_operators.selection.pairing import random_pairs
from gaitsim_operators.selection.ranking import best_first


class EliteAndLucky(Selection):
    """Keeps the best and some random others; parents are two different survivors.

    The random survivors preserve genes that the best have lost. A population smaller than both
    numbers together survives completely.
    """

    elite: int = option(16, "number of best individuals that survive", ge=1, le=100_000)
    lucky: int = option(4, "number of other individuals that survive at random", ge=0, le=100_000)

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return indices of random pairs of survivors, (pairs, 2), given scores, (population,)."""
        order = best_first(scores)
        lucky = rng.permutation(order[self.elite :])[: self.lucky]
        return random_pairs(np.concatenate((order[: self.elite], lucky)), pairs, rng)
