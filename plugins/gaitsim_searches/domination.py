"""Non-dominated sorting and crowding distance of individuals, for costs to minimise.

Deb, Pratap, Agarwal and Meyarivan 2002, "A fast and elitist multiobjective genetic algorithm:
NSGA-II", IEEE Transactions on Evolutionary Computation 6(2).
"""

import numpy as np
from numpy.typing import NDArray


def front_ranks(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the front of each individual: 0 if no other individual dominates it.

    Front 1 holds the individuals that are not dominated once front 0 is removed, and so on.

    Args:
        costs: costs, (individuals, objectives); all ∞ for a failed individual.

    Returns:
        (individuals,) int64, from 0.
    """
    # With two objectives, sorting replaces the comparison of all pairs, which halves the time for
    # 200 individuals.
    return _rank_by_sorting(costs) if costs.shape[1] == 2 else _rank_by_pairs(costs)


def _rank_by_sorting(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Sort individuals by the first of two costs; each front takes the new minima of the second."""
    order = np.lexsort(costs.T[::-1])
    ordered = costs[order]
    # Equal individuals share a front, so only the first is compared.
    distinct = np.ones(len(costs), np.bool_)
    distinct[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    left = np.flatnonzero(distinct)
    second = ordered[left, 1]
    ranks = np.zeros(len(costs), np.int64)
    rank = 0
    while len(left):
        front = np.ones(len(left), np.bool_)
        front[1:] = second[1:] < np.minimum.accumulate(second)[:-1]
        ranks[left[front]] = rank
        left, second, rank = left[~front], second[~front], rank + 1
    found = np.empty_like(ranks)
    found[order] = ranks[distinct][np.cumsum(distinct) - 1]
    return found


def _rank_by_pairs(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Rank individuals by removing fronts from the matrix of dominance."""
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
    """Return whether individuals dominate each other: no cost is higher and at least one is lower.

    Args:
        costs: costs, (individuals, objectives).

    Returns:
        (individuals, individuals) bool, true if the row's individual dominates the column's.
    """
    no_worse = np.ones((len(costs), len(costs)), np.bool_)
    for cost in costs.T:
        no_worse &= cost[:, None] <= cost
    return no_worse & ~no_worse.T


def crowding(costs: NDArray[np.float64], ranks: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the crowding distance of each individual in its front, (individuals,).

    It is the sum over the objectives of the distance between the two neighbours of the individual,
    as a share of the front's range; ∞ at the ends of a front. An objective that is equal
    throughout a front adds nothing.

    Args:
        costs: costs, (individuals, objectives), finite.
        ranks: front of each individual, (individuals,).
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
