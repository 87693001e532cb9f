"""Everything that determines a walker's rollout besides its commands."""

from dataclasses import dataclass

import numpy as np

from gaitsim.legged import delay_angles, hold_commands
from gaitsim_walker.body import FRAME_RATE, STOP, Floats, Plan
from gaitsim_walker.ground import Ground

STEP = 1 / (4 * FRAME_RATE)  # s: 240 Hz, four steps per frame


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The body, the ground, the servos, and the conditions of a world.

    Attributes:
        plan: build of the body.
        ground: the ground under the walker.
        gravity: acceleration of gravity, m/s².
        slope: slope of the ground, uphill, rad; x is along the slope and z normal to it.
        friction: friction of the feet on the ground.
        torque_limit: largest torque of each servo, N m.
        speed_limit: largest speed of each servo, rad/s.
        steps: number of physics steps per frame.
        mass: scale factor of the masses of all parts.
        latency: delay of the servos, s.
        command_rate: rate of the commands, Hz.
        joint_offset: constant error of each joint relative to its command, (joints,) rad.
        initial_pose: additional error of each joint at the start, (joints,) rad.
        push: frame after which the body is pushed, and the change of its forward velocity, m/s.
    """

    plan: Plan
    ground: Ground
    gravity: float
    slope: float
    friction: float
    torque_limit: float
    speed_limit: float
    steps: int
    mass: float
    latency: float
    command_rate: float
    joint_offset: Floats
    initial_pose: Floats
    push: tuple[int, float]

    @property
    def step(self) -> float:
        """Time step of the physics, s."""
        return 1 / (self.steps * FRAME_RATE)

    @property
    def weight(self) -> float:
        """Weight of the body, N."""
        return self.mass * self.plan.mass * self.gravity

    def pose(self, command: Floats) -> Floats:
        """Return the joint angles at the start, (joints,) rad, from the first command."""
        stops = self.plan.limits + STOP
        return np.clip(command + self.joint_offset + self.initial_pose, -stops, stops)

    def targets(self, commands: Floats) -> Floats:
        """Return the targets of the servos in each step, (steps, joints) rad.

        Args:
            commands: (frames, joints) rad. Each holds during the steps before its frame; the first
                is the initial pose.
        """
        held = hold_commands(commands, FRAME_RATE, self.command_rate, self.steps)
        arrived = delay_angles(held, self.latency / self.step)
        return arrived[self.steps :] + self.joint_offset
