"""A network that plays a gait by predicting each frame from the previous one."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.network import Network

Angles = NDArray[np.float64]
"""Joint angles, (frames, joints), radians."""

TURN = 2 * math.pi
"""Limit of commanded angles, a whole turn, so that a diverging network does not overflow."""


@dataclass(frozen=True, eq=False)
class Imitator:
    """A network that maps the joint angles of one frame to the joint angles of the next frame.

    Attributes:
        network: network with an input and an output for each joint.
        centre: angles at which the inputs are 0, (joints,), radians.
        scale: difference from the centre at which an input is 1, radians.
    """

    network: Network
    centre: NDArray[np.float64]
    scale: float

    def predict(self, frames: Angles) -> Angles:
        """Predict the frames after given frames, (frames, joints), radians."""
        answers: NDArray[Any] = self.network.activate(((frames - self.centre) / self.scale).T)
        return answers.T * self.scale + self.centre

    def free_run(self, first: NDArray[np.float64], frames: int) -> Angles:
        """Play without the expert: predict each frame from the previous prediction.

        Args:
            first: first frame, (joints,), radians.
            frames: number of frames, including the first.

        Returns:
            Joint angles, (frames, joints), radians.
        """
        played = np.empty((frames, len(first)))
        played[0] = first
        for frame in range(1, frames):
            commanded = self.predict(played[frame - 1 : frame])[0]
            played[frame] = np.clip(commanded, -TURN, TURN)
        return played

    def one_step_error(self, expert: Angles) -> float:
        """Return the mean squared error of predictions from the expert's frames, rad²."""
        return float(np.mean(np.square(self.predict(expert[:-1]) - expert[1:])))
