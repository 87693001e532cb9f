"""Everything that determines a walker's rollout besides its commands."""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from gaitsim.plugin.toolkit import delay_angles, hold_commands
from gaitsim_walker.body import FRAME_RATE, STOP, Floats, WalkerPlan
from gaitsim_walker.damage import Impairment

SPACING = 0.25  # m, horizontal distance between the corners of uneven ground
RUN_UP = 1.0  # m, length of flat ground on either side of the start
EDGE = 1e4  # m, distance of the outermost corners; the ground beyond the bumps is flat


@dataclass(frozen=True)
class Ground:
    """A profile of straight lines between corners.

    Attributes:
        x: positions of the corners, in ascending order, m.
        z: heights of the corners, m.
    """

    x: tuple[float, ...]
    z: tuple[float, ...]

    def height(self, x: float) -> float:
        """Return the height at x, m; for NaN, the height of the first corner."""
        at = min(max(bisect_right(self.x, x), 1), len(self.x) - 1)
        share = (x - self.x[at - 1]) / (self.x[at] - self.x[at - 1])
        return self.z[at - 1] + share * (self.z[at] - self.z[at - 1])


def ground(unevenness: float, seed: int, reach: float) -> Ground:
    """Return ground with corner heights drawn uniformly from 0 to `unevenness`.

    Args:
        unevenness: upper bound of the heights, m; 0 for flat ground.
        seed: seed of the heights, which are the same for any reach except at the last corner,
            whose height is 0.
        reach: distance from the start up to which the ground is uneven, in both directions, m.
    """
    if not unevenness:
        return Ground((-EDGE, EDGE), (0.0, 0.0))
    count = int(np.ceil((reach - RUN_UP) / SPACING)) + 1
    x = RUN_UP + SPACING * np.arange(max(count, 2))
    sides = []
    for side in (0, 1):  # separate generators, so that `reach` does not change the heights
        heights = unevenness * np.random.default_rng([seed, side]).random(len(x))
        heights[0] = heights[-1] = 0.0
        sides.append(heights)
    forward, backward = sides
    return Ground(
        (-EDGE, *(-x[::-1]).tolist(), *x.tolist(), EDGE),
        (0.0, *backward[::-1].tolist(), *forward.tolist(), 0.0),
    )


STEP = 1 / (4 * FRAME_RATE)  # s: 240 Hz, four steps per frame


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The body, its damage, the ground, the servos, and the conditions of a world.

    Attributes:
        plan: build of the body.
        damage: damage to the body.
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

    plan: WalkerPlan
    damage: Impairment
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
        lost = int(self.damage.lost.sum()) * self.plan.leg_mass
        return self.mass * (self.plan.mass - lost) * self.gravity

    def pose(self, command: Floats) -> Floats:
        """Return the joint angles at the start, (joints,) rad, from the first command."""
        stops = self.plan.limits + STOP
        pose = np.clip(command + self.joint_offset + self.initial_pose, -stops, stops)
        return self.damage.restrict(pose)

    def targets(self, commands: Floats) -> Floats:
        """Return the targets of the servos in each step, (steps, joints) rad.

        Args:
            commands: (frames, joints) rad. Each holds during the steps before its frame; the first
                is the initial pose.
        """
        held = hold_commands(commands, FRAME_RATE, self.command_rate, self.steps)
        arrived = delay_angles(held, self.latency / self.step)
        return arrived[self.steps :] + self.joint_offset
