"""The fitness `travel`: distance in a direction, minus penalties."""

import math

import numpy as np

from gaitsim.plugin import Array, Motion, option
from gaitsim.plugin.toolkit import cos, sin
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.measures import mean, rms
from gaitsim_robot.penalties import WalkingFitness, duration


class TravelFitness(WalkingFitness):
    """Metres travelled in the target direction, minus penalties in metres.

    Penalties for quantities that are not lengths, such as a fall or a radian of yaw, are in body
    lengths, and work is divided by the weight of the body, so that the same weights suit robots of
    0.2 m and of 1.5 m. A weight of 0 switches a term off.
    """

    direction: float = option(
        0.0,
        "target direction: 0 is forward, 90 is sideways to the left, 180 is backward",
        unit="°",
        ge=-180,
        le=180,
    )
    target_speed: float = option(
        0.0, "target speed, up to which distance counts; 0 for no limit", unit="m/s", ge=0
    )
    speed_weight: float = option(
        1.0, "penalty per metre beyond the distance at the target speed", ge=0
    )
    drift_weight: float = option(
        1.0,
        "penalty per metre of mean sideways distance from a straight path in the target direction",
        ge=0,
    )
    turn_weight: float = option(
        2.0, "penalty per radian of RMS yaw, in body lengths", unit="1/rad", ge=0
    )

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return forward, drift, turn, fall, energy, torque, roughness and slip, m.

        With a target speed, there is also the term `speed`.
        """
        distance, aside = self._along(motion["torso"])
        goal = self.target_speed * duration(motion) or math.inf
        yaw = motion["orientation"][..., 2]
        penalties = {
            "drift": self.drift_weight * mean(np.abs(aside)),
            "turn": self.turn_weight * motion["length"] * rms(yaw - yaw[:, :1]),
            **self.penalties(motion),
        }
        if self.target_speed:
            penalties["speed"] = self.speed_weight * np.maximum(distance - goal, 0.0)
        return {
            "forward": np.minimum(distance, goal),
            **{name: -penalty for name, penalty in penalties.items()},
        }

    def _along(self, torso: Array) -> tuple[Floats, Floats]:
        """Return the distance in the target direction, and the deviation to the left by frame.

        Returns:
            The distance, (population,) m, and the deviation, (population, frames) m.
        """
        # Exact for whole quarter turns, as cos(π/2) is not exactly 0 in floating point.
        quarters, rest = divmod(self.direction, 90)
        x, y = (float(part(math.radians(rest))) for part in (cos, sin))
        for _ in range(int(quarters) % 4):
            x, y = -y, x
        moved = torso - torso[:, :1]
        distance: Floats = x * moved[:, -1, 0] + y * moved[:, -1, 1]
        return distance, x * moved[..., 1] - y * moved[..., 0]
