"""A network that plays a gait: it predicts each frame from the one before."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.network import Network

Angles = NDArray[np.float64]
"""(frames, joints), radians."""

TURN = 2 * math.pi
"""Commanded angles are clipped to a whole turn, or a network that diverges would overflow."""


@dataclass(frozen=True, eq=False)
class Imitator:
    """A network from the joint angles of one frame to those of the next.

    Attributes:
        network: as many inputs as outputs.
        centre: angles that the network sees as 0, (joints,), radians.
        scale: angle that the network sees as 1, radians.
    """

    network: Network
    centre: NDArray[np.float64]
    scale: float

    def predict(self, frames: Angles) -> Angles:
        """Predict the next frame after each of (frames, joints)."""
        answers: NDArray[Any] = self.network.activate(((frames - self.centre) / self.scale).T)
        return answers.T * self.scale + self.centre

    def free_run(self, first: NDArray[np.float64], frames: int) -> Angles:
        """Play on its own, each frame from the one before; return (frames, joints).

        Args:
            first: the first frame, (joints,), radians.
            frames: number of frames, the first one included.
        """
        played = np.empty((frames, len(first)))
        played[0] = first
        for frame in range(1, frames):
            commanded = self.predict(played[frame - 1 : frame])[0]
            played[frame] = np.clip(commanded, -TURN, TURN)
        return played

    def one_step_error(self, expert: Angles) -> float:
        """Return the mean squared error of the next frame, given the expert's, rad²."""
        return float(np.mean((self.predict(expert[:-1]) - expert[1:]) ** 2))
