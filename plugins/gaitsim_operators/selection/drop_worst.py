"""Drop-worst selection: all individuals but the worst breed."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Selection


class DropWorst(Selection):
    """Drops the worst individual; every other individual breeds once, in random pairs.

    This is the weakest possible selection. If more parents are needed, every individual but the
    worst breeds once more, in a new random order.
    """

    portable: ClassVar[bool] = True

    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return the indices of pairs of parents, (pairs, 2), given scores, (population,).

        The parents of a pair differ if possible.
        """
        only: NDArray[np.intp] = self.parents_each(scores[None], pairs, rng)[0]
        return only

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Return parents, (populations, pairs, 2), given scores, (populations, population)."""
        populations, size = scores.shape
        count = max(1, size - 1)
        kept = np.argsort(-scores, axis=1, kind="stable")[:, :count]
        rounds = -(-2 * pairs // count)
        order = rng.permuted(np.repeat(kept, rounds, axis=0), axis=1).reshape(populations, -1)
        if count % 2 and count > 1:
            _avoid_self_pairs(order, count)
        return order[:, : 2 * pairs].reshape(populations, pairs, 2)

    def objection(self, population: int, elites: int, children: int) -> str:
        """Return why two children per pair do not fill the population exactly, or ''."""
        bred = population - elites
        if children == 2 and bred % 2:
            return (
                f"'drop-worst' breeds {bred:,} of {population:,} individuals in pairs with two "
                f"children each, but {bred:,} is odd"
            )
        return ""


def _avoid_self_pairs(order: NDArray[np.intp], count: int) -> None:
    """Break up pairs of an individual with itself, which may occur if `count` is odd, in place.

    Every second round starts with the father of the last mother of the previous round. If the two
    are the same individual, the next individual becomes the father.
    """
    fathers = np.arange(count, order.shape[1], 2 * count)
    rows, columns = np.nonzero(order[:, fathers] == order[:, fathers - 1])
    same = fathers[columns]
    order[rows, same], order[rows, same + 1] = order[rows, same + 1], order[rows, same]
