"""What a walker is in: its build, the ground, its servos and what happens to it."""

from dataclasses import dataclass

import numpy as np

from gaitsim.legged import delayed, held
from gaitsim_walker.body import FRAME_RATE, STOP, Floats, Plan
from gaitsim_walker.ground import Ground

STEP = 1 / (4 * FRAME_RATE)  # s: 240 Hz, four steps a frame


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The body, the ground, the servos, and what a world does to them.

    Attributes:
        plan: of the body.
        ground: that it walks on.
        gravity: m/s².
        slope: of the ground, uphill, rad; x is along it and z normal to it.
        friction: of feet on the ground.
        torque_limit: of each servo, N m.
        speed_limit: of each servo, rad/s.
        steps: number of physics steps a frame.
        mass: share of the masses of all parts.
        latency: of the servos, s.
        command_rate: at which commands arrive, Hz.
        joint_offset: by which each joint is off its command, (joints,) rad.
        initial_pose: by which each joint is off the first command at the start, (joints,) rad.
        push: frame after which the whole body's velocity changes, and by how much forward, m/s.
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
        """Of the body, N."""
        return self.mass * self.plan.mass * self.gravity

    def pose(self, command: Floats) -> Floats:
        """Return the joint angles at the start, (joints,) rad, from the first command."""
        stops = self.plan.limits + STOP
        return np.clip(command + self.joint_offset + self.initial_pose, -stops, stops)

    def targets(self, commands: Floats) -> Floats:
        """Return where the servos turn to in each step, (steps, joints) rad.

        Args:
            commands: (frames, joints) rad; those of a frame are in force before it, and the first
                is that of the pose at the start.
        """
        in_force = held(commands, FRAME_RATE, self.command_rate, self.steps)
        arrived = delayed(in_force, self.latency / self.step)
        return arrived[self.steps :] + self.joint_offset
