"""The world of a walker: plan, ground, gravity, friction and limits of the servos."""

from dataclasses import dataclass

from gaitsim_walker.body import FRAME_RATE, Plan
from gaitsim_walker.ground import Ground

STEP = 1 / (4 * FRAME_RATE)  # s: 240 Hz, four steps a frame


@dataclass(frozen=True)
class World:
    """The body, its surroundings and its servos.

    Attributes:
        plan: of the body.
        ground: that it walks on.
        gravity: m/s².
        friction: of feet on the ground.
        torque_limit: of each servo, N m.
        speed_limit: of each servo, rad/s.
        steps: number of physics steps a frame.
    """

    plan: Plan
    ground: Ground
    gravity: float
    friction: float
    torque_limit: float
    speed_limit: float
    steps: int

    @property
    def step(self) -> float:
        """Time step of the physics, s."""
        return 1 / (self.steps * FRAME_RATE)

    @property
    def weight(self) -> float:
        """Of the body, N."""
        return self.plan.mass * self.gravity
