"""The fitness `hover`, which rewards staying within a radius of a point."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim.portable import norm


class Hover(Fitness):
    """Share of the flight near a point, and mean nearness to it.

    Both terms are between 0 and 1, so a fly that stays at the point scores 2.
    """

    x: float = option(0.0, "x coordinate of the point to hover at", unit="m", ge=-1000, le=1000)
    y: float = option(0.0, "y coordinate of the point to hover at", unit="m", ge=-1000, le=1000)
    z: float = option(0.0, "z coordinate of the point to hover at", unit="m", ge=-1000, le=1000)
    radius: float = option(
        0.5, "largest distance at which a fly counts as being at the point", unit="m", gt=0, le=100
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("position",)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the share of the frames within the radius, and the mean nearness.

        Nearness is radius / (radius + distance). Both terms are means over frames and trials.
        """
        away = self.distance(motion)
        return {
            "within": (away <= self.radius).mean(axis=(1, 2)),
            "nearness": (self.radius / (self.radius + away)).mean(axis=(1, 2)),
        }

    def distance(self, motion: Motion) -> Array:
        """Return the distance from the point, (population, frames, trials), m."""
        point = np.array([self.x, self.y, self.z])
        return norm(motion["position"] - point)
