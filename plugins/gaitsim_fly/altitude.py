"""Fitness functions that reward altitude."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option


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
