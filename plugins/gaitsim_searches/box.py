"""Conversion of unbounded points to genomes within bounds, and back.

Points are in widths of the bounds, and are folded at the bounds.
"""

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import RealSpace

MARGIN = 0.025
"""Distance from a bound, in widths, within which the fold is a parabola."""


def genomes(points: NDArray[np.float64], space: RealSpace) -> NDArray[np.float64]:
    """Return the genomes at unbounded points, (points, genes) in widths above `lower`.

    Genomes equal their points inside the box. Points are mirrored at the bounds along a parabola,
    so that the fold is smooth; periodic genes wrap (`BoundTransform` of pycma).
    """
    period = 2 + 4 * MARGIN
    # The distance from the middle of the fold at the lower bound is at most half a period.
    distance = np.mod(points + MARGIN, period)
    distance = np.minimum(distance, period - distance)
    # Distances to the nearer bound; short ones are flattened.
    near = np.minimum(distance, period / 2 - distance)
    inside = np.where(near < 2 * MARGIN, np.square(near) / (4 * MARGIN), near - MARGIN)
    folded = np.where(distance < period / 4, inside, 1 - inside)
    if space.periodic is not None:
        folded = np.where(space.periodic, np.mod(points, 1.0), folded)
    return space.repair(space.lower + space.width * folded)


def point(genome: NDArray[np.float64], space: RealSpace) -> NDArray[np.float64]:
    """Return a point that `genomes` maps to a genome, (genes,)."""
    share = np.clip((genome - space.lower) / space.width, 0, 1)
    near = np.minimum(share, 1 - share)
    inside = np.where(near < MARGIN, np.sqrt(4 * MARGIN * near) - MARGIN, near)
    unfolded = np.where(share < 0.5, inside, 1 - inside)
    return unfolded if space.periodic is None else np.where(space.periodic, share, unfolded)
