"""The fly's fitness functions: altitude, hovering at a point, and following a course."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Fitness, Motion, option
from gaitsim.plugin.toolkit import cos, norm, sin


class MeanAltitude(Fitness):
    """Mean altitude over the flight."""

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("altitude",)
    unit: ClassVar[str] = "m"

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the altitude above the start, m, as a mean over time and trials."""
        return {"altitude": _altitude_gain(motion).mean(axis=(1, 2))}


class FinalAltitude(Fitness):
    """Altitude at the end of the flight."""

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("altitude",)
    unit: ClassVar[str] = "m"

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the altitude above the start at the end, m, as a mean over trials."""
        return {"altitude": _altitude_gain(motion)[:, -1].mean(axis=1)}


class Climb(Fitness):
    """Altitude at the end, minus a penalty for the mean horizontal distance from the start."""

    drift_weight: float = option(
        0.2, "penalty per metre of mean |x| and of mean |y|, in metres of altitude", ge=0
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("altitude", "position")
    unit: ClassVar[str] = "m"

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the final altitude and −drift_weight · (mean |x| + mean |y|), from the start, m.

        Both terms are means over trials.
        """
        position = motion["position"]
        away = np.abs(position[..., :2] - position[:, :1, :, :2])
        return {
            "altitude": _altitude_gain(motion)[:, -1].mean(axis=1),
            "drift": -self.drift_weight * away.mean(axis=(1, 2)).sum(axis=1),
        }


def _altitude_gain(motion: Motion) -> Array:
    """Return the altitude above the start, (population, frames, trials) m."""
    altitude = motion["altitude"]
    return np.asarray(altitude - altitude[:, :1])


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


class FollowCourse(Fitness):
    """Nearness to the course, minus a loss for leaning or pointing away from the heading.

    The score is a product, so it is low for a fly that falls upright and for a fly that tumbles in
    place. A fly that follows its course perfectly scores 1.
    """

    radius: float = option(
        0.5,
        "distance from the course at which the term 'nearness' is half its maximum",
        unit="m",
        gt=0,
        le=100,
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("position", "rotation", "course")

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return nearness and loss, as means over time and trials.

        Nearness is radius / (radius + distance). The loss leaves the share (1 + u)/2 · (1 + a)/2
        of it, where u and a are the cosines of the angles between the back and the vertical and
        between the nose and the heading.
        """
        course = motion["course"]
        away = norm(motion["position"] - course[..., :3])
        nearness = self.radius / (self.radius + away)
        w, x, y, z = np.moveaxis(motion["rotation"], -1, 0)
        ahead = (1 - 2 * (y * y + z * z)) * cos(course[..., 3])
        ahead = ahead + 2 * (x * y + w * z) * sin(course[..., 3])
        upright = 1 - 2 * (x * x + y * y)
        lost = nearness * ((1 + upright) * (1 + ahead) / 4 - 1)
        # The order of sums depends on the memory layout, and that of over 8,192 numbers on NumPy's
        # version; hence one axis after the other.
        return {
            name: np.ascontiguousarray(values.swapaxes(1, 2)).mean(axis=2).mean(axis=1)
            for name, values in (("nearness", nearness), ("attitude", lost))
        }
