"""The fitness `distance`: distance minus penalties."""

import math
from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option


class Distance(Fitness):
    """Metres gone forward, minus penalties in metres for movement that is not walking."""

    fall_weight: float = option(
        10.0,
        "price of falling at the start, and in proportion of falling later",
        unit="m",
        ge=0,
    )
    energy_weight: float = option(5.0, "price of a kilojoule of work", unit="m/kJ", ge=0)
    jerk_weight: float = option(
        0.5, "price of a root mean square change of torque of 100 N m/s", unit="m", ge=0
    )
    lag_weight: float = option(
        4.0,
        "price of a radian of root mean square deviation of the joints from their commands",
        unit="m",
        ge=0,
    )
    impact_weight: float = option(
        5.0,
        "price of a root mean square load on the feet of twice its mean",
        unit="m",
        ge=0,
    )
    low_height: float = option(
        0.85,
        "share of the height at the start below which the torso is low",
        ge=0,
        le=1,
    )
    low_weight: float = option(
        40.0, "price of a metre, root mean square, that the torso is too low", ge=0
    )
    bounce_weight: float = option(
        20.0, "price of a metre, root mean square, that the height varies", ge=0
    )
    pitch_weight: float = option(
        5.0, "price of a radian of root mean square pitch of the torso", unit="m", ge=0
    )
    slip_weight: float = option(1.0, "price of a metre that the stance feet slide", ge=0)

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
        """Forward, fall, energy, jerk, lag, impact, low, bounce, pitch and slip, all in metres."""
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
    """Root mean square over all but the population.

    One individual at a time: NumPy's order of summation may depend on the number.
    """
    return np.array([math.sqrt(float(np.mean(np.square(one)))) for one in values])


def _unevenness(motion: Motion) -> Array:
    """Root mean square load on all feet over its mean, less 1: 0 at rest, large in leaps.

    Until the fall; the load is 0 after it.
    """
    uneven = np.zeros(motion.population)
    for individual, lasted in enumerate(motion["lasted"]):
        load = motion["load"][individual, : round(lasted * motion.frame_rate) + 1, :, 1].sum(axis=1)
        mean = float(load.mean())
        if mean > 0:
            uneven[individual] = math.sqrt(float(np.mean(np.square(load)))) / mean - 1
    return uneven
