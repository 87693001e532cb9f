"""The fitness `spider-walk`, which rewards far, straight, level, stable and smooth walking."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Fitness, Motion, option
from gaitsim_spider.body import time_last


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
        from gaitsim_spider.sums import STATE, high_pass, sum_frames

        # One type, so that the kernel is compiled once for the motion of any body.
        pose, slip, margin, slope, angles = (
            time_last(motion[name].astype(np.float32, copy=False))
            for name in ("pose", "slip", "margin", "slope", "joint_angles")
        )
        rate, sums = motion.frame_rate, np.empty((motion.population, 8))
        safe_margin = np.float32(self.safe_margin)
        states = np.empty(1, STATE)
        sum_frames(pose, slip, margin, slope, angles, safe_margin, *high_pass(rate), states, sums)
        weights = {
            "forward": 1.0,
            "slip": -self.slip_weight,
            "drift": -self.drift_weight,
            "yaw": -self.yaw_weight,
            "slope": -self.slope_weight,
            "support": -self.support_weight,
            "vibration": -self.vibration_weight,
            "jerk": -self.jerk_weight * (rate * rate * rate),
        }
        return {name: weight * sums[:, n] for n, (name, weight) in enumerate(weights.items())}
