"""The ground: flat, or uneven by a seed."""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

SPACING = 0.25  # m, between the corners of uneven ground
RUN_UP = 1.0  # m, flat before and behind the start
BEYOND = 1e4  # m, flat ground after the bumps


@dataclass(frozen=True)
class Ground:
    """A line of corners from left to right, x and z in metres."""

    x: tuple[float, ...]
    z: tuple[float, ...]

    def height(self, x: float) -> float:
        """Return the height at x, m; that of the first corner where x is NaN."""
        at = min(max(bisect_right(self.x, x), 1), len(self.x) - 1)
        share = (x - self.x[at - 1]) / (self.x[at] - self.x[at - 1])
        return self.z[at - 1] + share * (self.z[at] - self.z[at - 1])


def ground(unevenness: float, seed: int, reach: float) -> Ground:
    """Return ground with corner heights drawn uniformly from 0 to `unevenness`.

    Args:
        unevenness: height of the highest corner, m; 0 makes it flat.
        seed: of the heights; the same seed draws the same ones for any reach,
            but for the last, which is 0.
        reach: how far it is uneven from the start, either way, m.
    """
    if not unevenness:
        return Ground((-BEYOND, BEYOND), (0.0, 0.0))
    count = int(np.ceil((reach - RUN_UP) / SPACING)) + 1
    x = RUN_UP + SPACING * np.arange(max(count, 2))
    ways = []
    for way in (0, 1):  # separate draws each way, so that reach changes none of them
        heights = np.random.default_rng([seed, way]).uniform(0.0, unevenness, len(x))
        heights[0] = heights[-1] = 0.0
        ways.append(heights)
    forward, backward = ways
    return Ground(
        (-BEYOND, *(-x[::-1]).tolist(), *x.tolist(), BEYOND),
        (0.0, *backward[::-1].tolist(), *forward.tolist(), 0.0),
    )
