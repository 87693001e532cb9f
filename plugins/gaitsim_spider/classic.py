"""The fitness `spider-classic`: the seven terms that the original MATLAB project describes."""

import math
from typing import ClassVar

import numpy as np

from gaitsim.plugin import Array, Fitness, Motion, option
from gaitsim_spider import body
from gaitsim_spider.body import time_last


class SpiderClassic(Fitness):
    """Seven weighted terms that consider each leg in isolation, as in the original MATLAB project.

    The fitness rewards feet that move forward or backward, whether or not they support the body. It
    is kept for comparison with `spider-walk`, which corrects these faults.
    """

    movement_scalar: float = option(
        1.0, "reward per metre that a foot travels along x, averaged over the feet", ge=0
    )
    band_reward_scalar: float = option(
        2.0, "reward for keeping all feet in the stance band all the time", ge=0
    )
    low_movement_penalty_scalar: float = option(
        10.0,
        "penalty if all legs are frozen; proportionally smaller if some of the legs that must "
        "move are",
        ge=0,
    )
    moving_legs: int = option(
        8,
        "minimum number of legs that must move: each leg below it costs its share of the penalty",
        ge=1,
        le=8,
    )
    penetration_scalar: float = option(
        50.0, "penalty per metre of mean depth of the feet below the floor", ge=0
    )
    variance_scalar: float = option(
        2000.0, "penalty per m² of variance of the supporting feet's heights", ge=0
    )
    overlapping_legs_fitness_scalar: float = option(
        20.0, "penalty per radian of mean coxa angle beyond the limit at which legs cross", ge=0
    )
    angle_change_scalar: float = option(
        50.0, "penalty per rad² of mean squared change of a joint from frame to frame", ge=0
    )
    stance_band: float = option(
        0.01, "half the height of the stance band around the floor", unit="m", gt=0, le=0.1
    )
    low_movement: float = option(
        0.1, "travel along x below which a foot counts as frozen", unit="m", ge=0, le=10
    )
    crossing_angle: float = option(
        20.0, "coxa angle at which a leg crosses its neighbour", unit="°", ge=0, le=30
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("joint_angles", "feet")

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the seven terms: movement, band, low movement, penetration and so on."""
        from gaitsim_spider.sums import leg_by_leg

        sums = np.empty((motion.population, 7))
        leg_by_leg(
            time_last(motion["feet"]),
            time_last(motion["joint_angles"]),
            np.float32(body.FOOT_RADIUS - body.STANDING_HEIGHT),
            np.float32(self.stance_band),
            np.float32(self.low_movement),
            np.float32(math.radians(self.crossing_angle)),
            sums,
        )
        # The share of frozen legs becomes the share of missing legs among those that must move.
        spare = 8 - self.moving_legs
        sums[:, 2] = np.maximum(8 * sums[:, 2] - spare, 0.0) / self.moving_legs
        weights = {
            "movement": self.movement_scalar,
            "band": self.band_reward_scalar,
            "low movement": -self.low_movement_penalty_scalar,
            "penetration": -self.penetration_scalar,
            "variance": -self.variance_scalar,
            "overlapping legs": -self.overlapping_legs_fitness_scalar,
            "angle change": -self.angle_change_scalar,
        }
        return {name: weight * sums[:, n] for n, (name, weight) in enumerate(weights.items())}
