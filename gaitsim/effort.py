"""The torque of a gait's servos over time, beside what they can deliver without overheating."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors

Floats = NDArray[np.float64]

STALL = 0.995  # share of the stall torque from which a servo counts as stalled


@dataclass(frozen=True, eq=False)
class Effort:
    """The torque of servos as shares of their stall torques, (joints,) each; 0 if unknown.

    Attributes:
        joints: names of the joints.
        peak: largest mean torque of a frame.
        rms: root mean square torque until a fall. The heat of a motor's windings grows with the
            square of its torque.
        continuous: torque that the servos can deliver for long without overheating.
    """

    joints: tuple[str, ...]
    peak: Floats
    rms: Floats
    continuous: Floats

    @property
    def peak_in_words(self) -> str:
        """The joints at stall, or the joint with the largest peak torque."""
        at_stall = np.flatnonzero(self.peak >= STALL)
        if not len(at_stall):
            return f"{self.joints[int(np.argmax(self.peak))]}, share of its stall torque"
        more = f" and {len(at_stall) - 1} more" if len(at_stall) > 1 else ""
        return f"at stall: {self.joints[at_stall[0]]}{more}"

    @property
    def rms_in_words(self) -> str:
        """The joint with the largest RMS torque, and its continuous torque."""
        hottest = int(np.argmax(self.rms))
        rating = float(self.continuous[hottest])
        beside = f"; {rating:.2f} continuous" if rating else ""
        return f"{self.joints[hottest]}, share of its stall torque{beside}"

    @property
    def warning(self) -> str:
        """A warning about servos that will overheat; '' if none will, as far as known."""
        rated = self.continuous > 0
        hot = np.flatnonzero(rated & (self.rms > self.continuous))
        if not len(hot):
            return ""
        ratio = self.rms / np.where(rated, self.continuous, np.inf)
        worst = int(np.argmax(ratio))
        return (
            f"Servos would overheat: the RMS torque of {len(hot)} of {len(self.joints)} joints "
            f"exceeds what their servos can deliver continuously; {self.joints[worst]} needs "
            f"{self.rms[worst]:.2f} of its stall torque, {ratio[worst]:.1f} times its rating."
        )


EFFORT = ("torque", "stall_torque", "rms_torque", "continuous_torque")
"""Channels of a body that measures the torque of its servos, over joints, in N m."""


def effort_of(individual: Individual) -> Effort | None:
    """Return the torque of the servos; None if the body lacks one of the channels `EFFORT`."""
    organism = individual.body
    found = [organism.channels.get(name) for name in EFFORT]
    if any(one is None or one.axes[-1:] != ("joints",) or one.unit != "N m" for one in found):
        return None
    torque, stall, rms, continuous = (channel_of(individual, name) for name in EFFORT)
    shares = [
        np.divide(values, stall, out=np.zeros_like(stall), where=stall > 0)
        for values in (torque.max(axis=0), rms, continuous)
    ]
    return Effort(tuple(organism.joint_names()), *shares)


def channel_of(individual: Individual, name: str) -> Floats:
    """Return a channel of one individual, without the axis of the population."""
    entry = individual.experiment.entries["organism"]
    channel = individual.body.channels[name]
    with plugin_errors(entry, f"computing the channel {name!r}"):
        values = np.asarray(individual.motion[name])
    if values.shape[:1] != (1,) or not channel.fits(values.shape):
        raise contract_error(
            entry, f"returned the channel {name!r} with the shape {values.shape}", channel.shape
        )
    return np.asarray(values[0], dtype=np.float64)


def gait_warnings(individual: Individual) -> tuple[str, ...]:
    """Return the warnings of the body about an individual; () for a gait from a file."""
    genome = individual.embodied.genome
    if genome is None:
        return ()
    with plugin_errors(individual.experiment.entries["organism"], "checking a gait for mistakes"):
        return tuple(individual.body.gait_warnings(genome.copy()))


def warnings_of(individual: Individual) -> tuple[str, ...]:
    """Return the warnings about servos that overheat, and those of the body."""
    effort = effort_of(individual)
    hot = effort.warning if effort is not None else ""
    return (*filter(None, [hot]), *gait_warnings(individual))
