"""What a walker walks in: its plan, the ground, gravity, friction, and what its servos can do."""

from dataclasses import dataclass

from gaitsim_walker.body import FRAME_RATE, Plan
from gaitsim_walker.ground import Ground

STEP = 1 / (4 * FRAME_RATE)  # s: 240 Hz, four steps a frame


@dataclass(frozen=True)
class World:
    """What a walker walks in and on.

    Attributes:
        plan: of the body.
        ground: that it walks on.
        gravity: m/s².
        friction: of feet on the ground.
        torque_limit: of each servo, N m.
        speed_limit: of each servo, rad/s.
        steps: of the physics a frame.
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
