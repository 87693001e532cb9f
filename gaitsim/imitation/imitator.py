"""A network that plays a gait: from each frame it makes the next."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.network import Network

Angles = NDArray[np.float64]
"""(frames, joints), radians."""

TURN = 2 * math.pi
"""What a network asks for beyond a whole turn is cut off, or one that runs away would overflow."""


@dataclass(frozen=True, eq=False)
class Imitator:
    """A network from the joint angles of one frame to those of the next.

    Attributes:
        network: as many inputs as outputs.
        centre: what the network knows as zero, (joints,), radians.
        scale: what it knows as one, radians.
    """

    network: Network
    centre: NDArray[np.float64]
    scale: float

    def following(self, frames: Angles) -> Angles:
        """The frame that the network makes of each of (frames, joints)."""
        answers: NDArray[Any] = self.network.activate(((frames - self.centre) / self.scale).T)
        return answers.T * self.scale + self.centre

    def free_run(self, first: NDArray[np.float64], frames: int) -> Angles:
        """What it plays on its own: each frame made of the one before, (frames, joints).

        Args:
            first: the first frame, (joints,), radians.
            frames: how many, the first one included.
        """
        played = np.empty((frames, len(first)))
        played[0] = first
        for frame in range(1, frames):
            asked = self.following(played[frame - 1 : frame])[0]
            played[frame] = np.clip(asked, -TURN, TURN)
        return played

    def one_step_error(self, teacher: Angles) -> float:
        """Mean squared error of the next frame, given the teacher's, rad²."""
        return mean_square(self.following(teacher[:-1]) - teacher[1:])


def mean_square(values: NDArray[np.float64]) -> float:
    """Their mean square."""
    return float(np.mean(values**2))
