"""Non-dominated sorting and crowding: which individuals of a population a front is made of.

Deb, Pratap, Agarwal and Meyarivan 2002, "A fast and elitist multiobjective genetic algorithm:
NSGA-II", IEEE Transactions on Evolutionary Computation 6(2). Costs are minimised here.
"""

import numpy as np
from numpy.typing import NDArray


def front_ranks(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the front of each individual: 0 where no other dominates it.

    Front 1 is what nobody dominates once front 0 is taken away, and so on.

    Args:
        costs: (individuals, objectives), less is better; ∞ in all of them for a failed one.

    Returns:
        (individuals,) int64, from 0.
    """
    # Two objectives need no comparison of all pairs: half the time at 200 individuals.
    return _ranks_of_two(costs) if costs.shape[1] == 2 else _ranks_of_many(costs)


def _ranks_of_two(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Peel fronts off a list sorted by the first cost: each takes the second's new minima."""
    order = np.lexsort(costs.T[::-1])
    ordered = costs[order]
    # Equal individuals share a front, so only the first of them is compared.
    fresh = np.ones(len(costs), np.bool_)
    fresh[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    left = np.flatnonzero(fresh)
    second = ordered[left, 1]
    ranks = np.zeros(len(costs), np.int64)
    rank = 0
    while len(left):
        front = np.ones(len(left), np.bool_)
        front[1:] = second[1:] < np.minimum.accumulate(second)[:-1]
        ranks[left[front]] = rank
        left, second, rank = left[~front], second[~front], rank + 1
    found = np.empty_like(ranks)
    found[order] = ranks[fresh][np.cumsum(fresh) - 1]
    return found


def _ranks_of_many(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Peel fronts off the matrix of who dominates whom."""
    dominates = dominating(costs)
    ranks = np.full(len(costs), -1, np.int64)
    above = dominates.sum(axis=0)
    rank = 0
    while (left := ranks < 0).any():
        front = left & (above == 0)
        ranks[front] = rank
        above -= dominates[front].sum(axis=0)
        rank += 1
    return ranks


def dominating(costs: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether one dominates another: nowhere worse and somewhere better.

    Args:
        costs: (individuals, objectives), less is better.

    Returns:
        (individuals, individuals) bool, true where the row's individual dominates the column's.
    """
    no_worse = np.ones((len(costs), len(costs)), np.bool_)
    for cost in costs.T:
        no_worse &= cost[:, None] <= cost
    return no_worse & ~no_worse.T


def crowding(costs: NDArray[np.float64], ranks: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return how far apart the neighbours of each individual are in its front.

    The sum over the objectives of the distance between the individual before and the one
    after it, in ranges of that front; ∞ at its ends. An objective in which a whole
    front is equal adds nothing.

    Args:
        costs: (individuals, objectives), finite.
        ranks: front of each, (individuals,).
    """
    distance = np.zeros(len(costs))
    for cost in costs.T:
        order = np.lexsort((cost, ranks))
        ordered, front = cost[order], ranks[order]
        first = np.flatnonzero(np.diff(front, prepend=-1))
        last = np.append(first[1:], len(front)) - 1
        gap = np.empty(len(front))
        gap[1:-1] = ordered[2:] - ordered[:-2]
        gap[first] = gap[last] = np.inf
        width = np.repeat(ordered[last] - ordered[first], last - first + 1)
        distance[order] += np.divide(gap, width, out=np.zeros_like(gap), where=width > 0)
    return distance
