"""The fitness `hover`: stay within a radius of a point."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option


class Hover(Fitness):
    """Share of the flight near a point, and mean nearness to it.

    Both terms lie between 0 and 1, so a fly that holds its place scores up to 2.
    """

    x: float = option(0.0, "x of the point", unit="m", ge=-1000, le=1000)
    y: float = option(0.0, "y of the point", unit="m", ge=-1000, le=1000)
    z: float = option(0.0, "z of the point", unit="m", ge=-1000, le=1000)
    radius: float = option(0.5, "distance that counts as at the point", unit="m", gt=0, le=100)

    needs: ClassVar[tuple[str, ...]] = ("position",)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Within the radius, and nearness radius / (radius + distance); means over trials."""
        away = self.distance(motion)
        return {
            "within": (away <= self.radius).mean(axis=(1, 2)),
            "nearness": (self.radius / (self.radius + away)).mean(axis=(1, 2)),
        }

    def distance(self, motion: Motion) -> Array:
        """Distance from the point, (population, frames, trials), m."""
        point = np.array([self.x, self.y, self.z])
        return np.asarray(np.linalg.norm(motion["position"] - point, axis=-1))
