"""The fitness `spider-walk`, which rewards far, straight, level, stable and smooth walking."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim_spider.layout import time_last


class SpiderWalk(Fitness):
    """Metres walked forward, minus penalties in metres for motion that robots cannot perform."""

    slip_weight: float = option(0.5, "penalty per metre that the stance feet slide", ge=0)
    drift_weight: float = option(
        1.0, "penalty per metre of mean distance from the straight line ahead", ge=0
    )
    yaw_weight: float = option(4.0, "penalty per radian of RMS yaw", unit="m", ge=0)
    slope_weight: float = option(
        2.0, "penalty per radian of RMS tilt of the resting plane", unit="m", ge=0
    )
    safe_margin: float = option(
        0.02, "stability margin below which a frame counts as unsupported", unit="m", ge=0, le=0.1
    )
    support_weight: float = option(
        2.0,
        "penalty if the body is unsupported all the time; proportionally smaller for a part of "
        "the time",
        unit="m",
        ge=0,
    )
    vibration_weight: float = option(
        20.0, "penalty per radian of RMS joint motion above 5 Hz", unit="m", ge=0
    )
    jerk_weight: float = option(1e-4, "penalty per rad/s³ of RMS joint jerk", unit="m", ge=0)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("joint_angles", "pose", "slip", "margin", "slope")
    unit: ClassVar[str] = "m"

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return forward, slip, drift, yaw, slope, support, vibration and jerk, in metres."""
        from gaitsim_spider.roughness import high_pass, roughness

        pose, angles = motion["pose"].astype(np.float64), motion["joint_angles"]
        rate = motion.frame_rate
        vibration, jerk = np.empty(motion.population), np.empty(motion.population)
        roughness(time_last(angles), *high_pass(rate), vibration, jerk)
        return {
            "forward": pose[:, -1, 0],
            "slip": -self.slip_weight * motion["slip"][:, :-1].sum(axis=1, dtype=np.float64),
            "drift": -self.drift_weight * np.abs(pose[:, :, 1]).mean(axis=1),
            "yaw": -self.yaw_weight * _rms(pose[:, :, 2]),
            "slope": -self.slope_weight * _rms(motion["slope"]),
            "support": -self.support_weight * np.mean(motion["margin"] < self.safe_margin, axis=1),
            "vibration": -self.vibration_weight * vibration,
            "jerk": -self.jerk_weight * jerk * (rate * rate * rate),
        }


def _rms(values: Array) -> NDArray[np.float64]:
    """Return the root mean square of each individual's values, in double precision."""
    axes = tuple(range(1, values.ndim))
    result: NDArray[np.float64] = np.sqrt(np.mean(np.square(values), axis=axes, dtype=np.float64))
    return result
