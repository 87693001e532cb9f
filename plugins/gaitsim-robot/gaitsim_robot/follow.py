"""The fitness `follow`: how well a robot follows its commands, and keeps its heading."""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Motion, option
from gaitsim.plugin.toolkit import cos, norm, sin
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.measures import mean, rms, total
from gaitsim_robot.penalties import WalkingFitness, duration


class FollowFitness(WalkingFitness):
    """Metres commanded, minus the error of the path and other penalties in metres.

    In each window of time, the commands lead from the robot's actual pose at its start along a
    path. The error of the path is twice the mean distance between the robot and its place on that
    path, summed over the windows: a robot that stands still while the command is to walk straight
    has an error equal to the distance commanded, and a robot at half the speed half of it. The
    heading is that of the start plus the commanded turns, and is never reset. The other penalties
    are those of `travel`.
    """

    window: float = option(
        2.0,
        "time after which the commanded path restarts at the robot's actual pose",
        unit="s",
        ge=0.2,
        le=60,
    )
    path_weight: float = option(1.0, "penalty per metre of error of the path", ge=0)
    heading_weight: float = option(
        2.0, "penalty per radian of RMS error of the heading, in body lengths", unit="1/rad", ge=0
    )
    height_weight: float = option(
        1.0, "penalty per metre of mean error of the trunk's height above the ground", ge=0
    )

    needs: ClassVar[tuple[str, ...]] = ("command", "height", *WalkingFitness.needs)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return commanded, path, heading, height, fall, energy, torque, roughness and slip, m.

        The command in a frame holds until the next frame.
        """
        command, height, yaw = motion["command"], motion["height"], motion["orientation"][..., 2]
        speed, turn, sideways, _ = np.moveaxis(command[:, :-1] / motion.frame_rate, -1, 0)
        turned = _running_sum(turn)
        penalties = {
            "path": self.path_weight * self._path_error(motion, speed, sideways, turned),
            "heading": self.heading_weight * motion["length"] * rms(yaw - yaw[:, :1] - turned),
            "height": self.height_weight * mean(np.abs(height - height[:, :1] - command[..., 3])),
            **self.penalties(motion),
        }
        return {
            "commanded": total(norm(np.stack([speed, sideways], axis=-1))),
            **{name: -penalty for name, penalty in penalties.items()},
        }

    def _path_error(self, motion: Motion, speed: Array, sideways: Array, turned: Floats) -> Floats:
        """Return the error of the path, (population,) m.

        Args:
            motion: motion of the population.
            speed: commanded distance forward until the next frame, (population, frames - 1) m.
            sideways: commanded distance to the left, (population, frames - 1) m.
            turned: commanded turns since the start, (population, frames) rad.
        """
        torso, yaw = motion["torso"][..., :2], motion["orientation"][..., 2]
        number = max(1, round(duration(motion) / self.window))
        bounds = np.rint(np.linspace(0, torso.shape[1] - 1, number + 1)).astype(int)
        middle = (turned[:, :-1] + turned[:, 1:]) / 2  # heading halfway between frames
        error = np.zeros(motion.population)
        for first, last in pairwise(bounds.tolist()):
            step = slice(first, last)
            heading = yaw[:, first, None] + middle[:, step] - turned[:, first, None]
            along, left = cos(heading), sin(heading)
            x = _running_sum(speed[:, step] * along - sideways[:, step] * left)
            y = _running_sum(speed[:, step] * left + sideways[:, step] * along)
            moved = torso[:, first : last + 1] - torso[:, first, None]
            error += 2 * mean(norm(moved - np.stack([x, y], axis=-1)))
        return error


def _running_sum(steps: Array) -> Floats:
    """Return the sum of all steps before each frame, (population, steps + 1)."""
    return np.pad(np.cumsum(steps, axis=1), ((0, 0), (1, 0)))
