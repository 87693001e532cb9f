"""Exact hypervolume: the volume of the objective space that a front dominates."""

import numpy as np
from numpy.typing import NDArray

from gaitsim_searches.domination import dominating


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
