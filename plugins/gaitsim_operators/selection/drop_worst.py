"""Drop-worst selection: all but the worst breed."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection
from gaitsim_operators.selection.ranking import best_first


class DropWorst(Selection):
    """Drops the worst; every other individual breeds once, in random pairs.

    The weakest selection there is. Where more parents are wanted than there
    are, another round begins, shuffled anew.
    """

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Scores (population,) -> pairs of different individuals, if there are two, (pairs, 2)."""
        kept = best_first(scores)[: max(1, len(scores) - 1)]
        rounds = -(-2 * pairs // len(kept))
        turns = rng.permuted(np.tile(kept, (rounds, 1)), axis=1).ravel()
        if len(kept) % 2 and len(kept) > 1:
            _part_twins(turns, len(kept))
        return turns[: 2 * pairs].reshape(pairs, 2)


def _part_twins(turns: NDArray[np.intp], count: int) -> None:
    """Keep the last of a round of odd `count` from being paired with itself, in place.

    Every second round then begins with a father, whose mother ended the round
    before. If they are the same individual, the next in turn becomes the father.
    """
    fathers = np.arange(count, len(turns), 2 * count)
    twins = fathers[turns[fathers] == turns[fathers - 1]]
    turns[twins], turns[twins + 1] = turns[twins + 1], turns[twins]
