"""Penalties for falls and effort that the fitnesses of walking robots share."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Fitness, Motion, option
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.measures import ratio, rms, total


class WalkingFitness(Fitness):
    """A fitness in metres with penalties for a fall, energy, torque, roughness and slip."""

    fall_weight: float = option(
        20.0,
        "penalty for falling at the start, in body lengths; half as much for falling at the end",
        ge=0,
    )
    energy_weight: float = option(
        0.1, "penalty per metre travelled at a cost of transport of 1", ge=0
    )
    torque_share: float = option(
        0.5, "share of the stall torque above which torque is penalised", ge=0, le=1
    )
    torque_weight: float = option(
        10.0,
        "penalty, in body lengths, if the RMS torque above 'torque_share' equals the stall torque",
        ge=0,
    )
    rough_frequency: float = option(
        5.0, "frequency above which joint motion counts as shaking", unit="Hz", ge=0.5, le=50
    )
    rough_weight: float = option(
        20.0,
        "penalty per radian of RMS joint motion above 'rough_frequency', in body lengths",
        unit="1/rad",
        ge=0,
    )
    slip_weight: float = option(0.5, "penalty per metre that the stance feet slide", ge=0)

    unit: ClassVar[str] = "m"
    needs: ClassVar[tuple[str, ...]] = (
        "torso",
        "orientation",
        "joint_positions",
        "torque",
        "stall_torque",
        "energy",
        "slip",
        "lasted",
        "weight",
        "length",
    )

    def penalties(self, motion: Motion) -> dict[str, Floats]:
        """Return the penalties for fall, energy, torque, roughness and slip, (population,) m.

        Joints with an unknown stall torque contribute nothing to `torque`; `energy` is 0 without
        gravity, and `roughness` is 0 if the frame rate is too low for `rough_frequency`.
        """
        length, seconds = motion["length"], duration(motion)
        return {
            "fall": self.fall_weight * length * _fallen(motion["lasted"], seconds),
            "energy": self.energy_weight * ratio(motion["energy"][:, -1], motion["weight"]),
            "torque": self.torque_weight * length * self._overload(motion),
            "roughness": self.rough_weight * length * self._roughness(motion),
            "slip": self.slip_weight * total(motion["slip"]),
        }

    def _overload(self, motion: Motion) -> Floats:
        """Return the RMS torque above `torque_share`, as a share of the stall torque."""
        stall = motion["stall_torque"][:, None]
        beyond = ratio(motion["torque"], np.broadcast_to(stall, motion["torque"].shape))
        return joint_rms(motion, np.maximum(beyond - self.torque_share, 0.0))

    def _roughness(self, motion: Motion) -> Floats:
        """Return the RMS joint motion above `rough_frequency`, rad.

        The filter is a Butterworth high-pass of fourth order, at rest before the first frame.
        """
        if not self.rough_weight or self.rough_frequency >= motion.frame_rate / 2:
            return np.zeros(motion.population)
        from scipy.signal import butter, sosfilt

        angles = motion["joint_positions"]
        sections = butter(4, self.rough_frequency, "highpass", fs=motion.frame_rate, output="sos")
        return joint_rms(motion, sosfilt(sections, angles - angles[:, :1], axis=1))


def joint_rms(motion: Motion, values: Floats) -> Floats:
    """Return the RMS of values, (population, frames, joints), over the joints that exist.

    With the channel `present`, joints that only pad the array change no bits.
    """
    if "present" not in motion:
        return rms(values)
    by_joint = np.ascontiguousarray(np.square(values).swapaxes(1, 2)).sum(axis=2)
    present = motion["present"].sum(axis=1)
    count = np.asarray(values.shape[1] * present, np.float64)
    return np.sqrt(ratio(np.cumsum(by_joint, axis=1)[:, -1], count))


def duration(motion: Motion) -> float:
    """Return the duration of a motion, s."""
    frames: int = motion["torso"].shape[1]
    return (frames - 1) / motion.frame_rate


def _fallen(lasted: Array, seconds: float) -> Floats:
    """Return 1 for a fall at the start, decreasing to 1/2 at the end; 0 without a fall."""
    share = np.minimum(lasted / seconds, 1.0)
    # A truncated motion may end before its fall.
    fallen: Floats = np.where(share < 1.0, 1.0 - share / 2, 0.0)
    return fallen
