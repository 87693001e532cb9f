"""The fitness `distance`: forward distance minus penalties."""

import math
from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Fitness, Motion, option


class Distance(Fitness):
    """Metres walked forward, minus penalties in metres for movement other than walking."""

    fall_weight: float = option(
        10.0,
        "penalty for falling at the start, proportionally smaller for later falls",
        unit="m",
        ge=0,
    )
    energy_weight: float = option(5.0, "penalty per kilojoule of work", unit="m/kJ", ge=0)
    jerk_weight: float = option(
        0.5, "penalty per 100 N m/s of RMS rate of change of the torque", unit="m", ge=0
    )
    lag_weight: float = option(
        4.0, "penalty per radian of RMS deviation of the joints from their commands", unit="m", ge=0
    )
    impact_weight: float = option(
        5.0,
        "penalty if the RMS load on the feet is twice the mean load; 0 for a constant load",
        unit="m",
        ge=0,
    )
    low_height: float = option(
        0.85, "share of the initial height below which the torso is too low", ge=0, le=1
    )
    low_weight: float = option(
        40.0, "penalty per metre of RMS drop of the torso below 'low_height'", ge=0
    )
    bounce_weight: float = option(
        20.0, "penalty per metre of RMS variation in the torso's height", ge=0
    )
    pitch_weight: float = option(
        5.0, "penalty per radian of RMS pitch of the torso", unit="m", ge=0
    )
    slip_weight: float = option(1.0, "penalty per metre that the stance feet slide", ge=0)

    unit: ClassVar[str] = "m"
    needs: ClassVar[tuple[str, ...]] = (
        "joint_angles",
        "joint_positions",
        "torque",
        "torso",
        "pitch",
        "height",
        "slip",
        "load",
        "energy",
        "lasted",
    )

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return forward, fall, energy, jerk, lag, impact, low, bounce, pitch and slip, m."""
        forward = motion["torso"][:, -1, 0] - motion["torso"][:, 0, 0]
        whole = (motion["pitch"].shape[1] - 1) / motion.frame_rate
        height = motion["height"]
        low = np.maximum(self.low_height * height[:, :1] - height, 0.0)
        bounce = height - height.mean(axis=1, keepdims=True)
        jerk = np.diff(motion["torque"][:, 1:], axis=1) * motion.frame_rate
        lag = motion["joint_angles"] - motion["joint_positions"]
        return {
            "forward": forward,
            "fall": -self.fall_weight * (1 - motion["lasted"] / whole),
            "energy": -self.energy_weight * motion["energy"][:, -1] / 1000,
            "jerk": -self.jerk_weight * _rms(jerk) / 100,
            "lag": -self.lag_weight * _rms(lag),
            "impact": -self.impact_weight * _unevenness(motion),
            "low": -self.low_weight * _rms(low),
            "bounce": -self.bounce_weight * _rms(bounce),
            "pitch": -self.pitch_weight * _rms(motion["pitch"]),
            "slip": -self.slip_weight * motion["slip"].sum(axis=1),
        }


def _rms(values: Array) -> Array:
    """Return the root mean square over all axes but the population.

    It is computed for one individual at a time, as NumPy's order of summation may depend on the
    shape of the array.
    """
    return np.array([math.sqrt(float(np.mean(np.square(one)))) for one in values])


def _unevenness(motion: Motion) -> Array:
    """Return the root mean square load on all feet divided by its mean, minus 1, (population,).

    It is 0 at rest, and large for a body that leaps. Frames after a fall, whose load is 0, are
    ignored.
    """
    uneven = np.zeros(motion.population)
    for individual, lasted in enumerate(motion["lasted"]):
        load = motion["load"][individual, : round(lasted * motion.frame_rate) + 1, :, 1].sum(axis=1)
        mean = float(load.mean())
        if mean > 0:
            uneven[individual] = math.sqrt(float(np.mean(np.square(load)))) / mean - 1
    return uneven
