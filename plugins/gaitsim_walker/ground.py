"""The ground: flat, or uneven with random heights from a seed."""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

SPACING = 0.25  # m, horizontal distance between the corners of uneven ground
RUN_UP = 1.0  # m, length of flat ground on either side of the start
EDGE = 1e4  # m, distance of the outermost corners; the ground beyond the bumps is flat


@dataclass(frozen=True)
class Ground:
    """A profile of straight lines between corners.

    Attributes:
        x: positions of the corners, in ascending order, m.
        z: heights of the corners, m.
    """

    x: tuple[float, ...]
    z: tuple[float, ...]

    def height(self, x: float) -> float:
        """Return the height at x, m; for NaN, the height of the first corner."""
        at = min(max(bisect_right(self.x, x), 1), len(self.x) - 1)
        share = (x - self.x[at - 1]) / (self.x[at] - self.x[at - 1])
        return self.z[at - 1] + share * (self.z[at] - self.z[at - 1])


def ground(unevenness: float, seed: int, reach: float) -> Ground:
    """Return ground with corner heights drawn uniformly from 0 to `unevenness`.

    Args:
        unevenness: upper bound of the heights, m; 0 for flat ground.
        seed: seed of the heights, which are the same for any reach except at the last corner,
            whose height is 0.
        reach: distance from the start up to which the ground is uneven, in both directions, m.
    """
    if not unevenness:
        return Ground((-EDGE, EDGE), (0.0, 0.0))
    count = int(np.ceil((reach - RUN_UP) / SPACING)) + 1
    x = RUN_UP + SPACING * np.arange(max(count, 2))
    sides = []
    for side in (0, 1):  # separate generators, so that `reach` does not change the heights
        heights = unevenness * np.random.default_rng([seed, side]).random(len(x))
        heights[0] = heights[-1] = 0.0
        sides.append(heights)
    forward, backward = sides
    return Ground(
        (-EDGE, *(-x[::-1]).tolist(), *x.tolist(), EDGE),
        (0.0, *backward[::-1].tolist(), *forward.tolist(), 0.0),
    )
