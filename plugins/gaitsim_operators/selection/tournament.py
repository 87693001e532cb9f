"""Tournament selection: the best of a few random individuals breeds."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection, option


class Tournament(Selection):
    """Chooses each parent as the best of a few entrants, drawn with replacement.

    Goldberg and Deb 1991. Of n individuals, one that i others beat wins with probability
    ((n − i)^size − (n − i − 1)^size) / n^size.
    """

    size: int = option(
        2, "number of individuals in each tournament; 1 chooses at random", ge=1, le=1000
    )

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return the indices of pairs of winners, (pairs, 2), given scores, (population,).

        Ties go to the entrant drawn first, so that no position in the population is favoured.
        """
        entrants = rng.integers(0, len(scores), (2 * pairs, self.size), dtype=np.intp)
        best = scores[entrants].argmax(axis=1)
        winners: NDArray[np.intp] = entrants[np.arange(2 * pairs), best]
        return winners.reshape(pairs, 2)
