"""Non-dominated sorting, crowding distance and exact hypervolume, for costs to minimise."""

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


def hypervolume(costs: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the volume between a reference point and the front of a set of points.

    Zitzler and Thiele 1998. With two and three objectives, it sums over the grid that the points
    span. With more, it sums slices along the last objective, less the parts that other points
    dominate, as in WFG (While, Bradstreet and Barone 2012, "A fast way of calculating exact
    hypervolumes"). For 100 points it takes milliseconds with four objectives, seconds with six.

    Args:
        costs: costs to minimise, (points, objectives). Points that are not better than the
            reference in every objective add nothing.
        reference: reference point, (objectives,), finite.
    """
    inside = costs[(costs < reference).all(axis=1)]
    return _volume(reference - inside)


def _volume(sides: NDArray[np.float64]) -> float:
    """Return the volume of a union of boxes, (boxes, sides), that share one corner."""
    if not len(sides):
        return 0.0
    if sides.shape[1] <= 3:
        return _on_a_grid(sides)
    front = np.unique(sides[~dominating(-sides).any(axis=0)], axis=0)
    front = front[np.argsort(-front[:, -1], kind="stable")]
    total = 0.0
    for index, side in enumerate(front):
        # All earlier boxes are at least as long along the last objective, so their overlap with
        # this box does not depend on that objective.
        base = side[:-1]
        total += side[-1] * (np.prod(base) - _volume(np.minimum(front[:index, :-1], base)))
    return float(total)


def _on_a_grid(sides: NDArray[np.float64]) -> float:
    """Return the volume with two or three objectives, summed over the cells of a grid.

    The sides of all boxes, except those along the last objective, span the grid. A cell is as high
    as the highest box over it.
    """
    *axes, heights = sides.T
    edges = [np.sort(axis) for axis in axes]
    steps = [np.diff(edge, prepend=0.0) for edge in edges]
    cells = tuple(
        np.searchsorted(edge, axis, side="right") - 1
        for edge, axis in zip(edges, axes, strict=True)
    )
    height = np.zeros((len(sides),) * len(axes))
    np.maximum.at(height, cells, heights)
    for axis in range(len(axes)):
        height = np.flip(np.maximum.accumulate(np.flip(height, axis), axis=axis), axis)
    for step in reversed(steps):
        height = (height * step).sum(axis=-1)
    return float(height)
