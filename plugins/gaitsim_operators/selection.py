"""Selection operators, which choose parents."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Selection, option
from gaitsim_operators.shared import distinct_pairs


def best_first(scores: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices of scores, (population,), from best to worst; ties keep their order."""
    return np.argsort(-scores, kind="stable")


def random_pairs(
    survivors: NDArray[np.intp], pairs: int, rng: np.random.Generator
) -> NDArray[np.intp]:
    """Draw pairs of different survivors; all ordered pairs are equally likely.

    Args:
        survivors: indices of the survivors, (survivors,); a single one is paired with itself.
        pairs: number of pairs to draw.
        rng: the only source of randomness.

    Returns:
        Indices of mothers and fathers, (pairs, 2).
    """
    if len(survivors) == 1:
        return np.full((pairs, 2), survivors[0])
    positions = np.stack(distinct_pairs(len(survivors), pairs, rng), axis=1)
    chosen: NDArray[np.intp] = survivors[positions]
    return chosen


def spin(weights: NDArray[np.float64], pairs: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw positions in proportion to weights, with replacement.

    Args:
        weights: weights, (population,), not negative, at least one positive.
        pairs: number of pairs to draw.
        rng: the only source of randomness.

    Returns:
        Positions of mothers and fathers, (pairs, 2), all with positive weights.
    """
    edges = np.cumsum(weights)
    # Draws are below 1, so their products are below the last edge even after rounding.
    positions: NDArray[np.intp] = np.searchsorted(
        edges, rng.random((pairs, 2)) * edges[-1], side="right"
    )
    return positions


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
