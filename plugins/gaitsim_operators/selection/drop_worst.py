"""Drop-worst selection: all but the worst breed."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection


class DropWorst(Selection):
    """Drops the worst; every other individual breeds once, in random pairs.

    The weakest selection possible. If more parents are needed than there are,
    another round follows in another random order.
    """

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Scores (population,) -> pairs of different individuals, if there are two, (pairs, 2)."""
        only: NDArray[np.intp] = self.parents_each(scores[None], pairs, rng)[0]
        return only

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Scores (populations, population) -> pairs of each, (populations, pairs, 2)."""
        populations, size = scores.shape
        count = max(1, size - 1)
        kept = np.argsort(-scores, axis=1, kind="stable")[:, :count]
        rounds = -(-2 * pairs // count)
        turns = rng.permuted(np.repeat(kept, rounds, axis=0), axis=1).reshape(populations, -1)
        if count % 2 and count > 1:
            _part_twins(turns, count)
        return turns[:, : 2 * pairs].reshape(populations, pairs, 2)

    def objection(self, population: int, elites: int, children: int) -> str:
        """Pairs with two children each need an even number of individuals to breed."""
        bred = population - elites
        if children == 2 and bred % 2:
            return (
                f"drop-worst breeds {bred:,} of {population:,} in pairs with two children each, "
                f"and {bred:,} is odd"
            )
        return ""


def _part_twins(turns: NDArray[np.intp], count: int) -> None:
    """Keep the last of a round of odd `count` from being paired with itself, in place.

    Every second round then begins with a father, whose mother ended the round
    before. If they are the same individual, the next in turn becomes the father.
    """
    fathers = np.arange(count, turns.shape[1], 2 * count)
    rows, columns = np.nonzero(turns[:, fathers] == turns[:, fathers - 1])
    twins = fathers[columns]
    turns[rows, twins], turns[rows, twins + 1] = turns[rows, twins + 1], turns[rows, twins]
