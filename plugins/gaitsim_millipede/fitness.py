"""The fitness `millipede-travel`: motion per cycle in one of four directions."""

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Array, Fitness, Motion, option

Values = NDArray[np.float64]


def forward_motion(sides: Values) -> Values:
    """Return the forward motion, which is the motion of the slower side; negative backward.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        The motion, (population,), in the unit of `sides`; 0 if the sides move in opposite
        directions.
    """
    less, more = sides.min(axis=1), sides.max(axis=1)
    moved: Values = np.maximum(less, 0) + np.minimum(more, 0)  # one of the two is 0
    return moved


def clockwise_motion(sides: Values) -> Values:
    """Return the clockwise motion, left − right; negative counter-clockwise.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        The motion, (population,), in the unit of `sides`; 0 unless the sides move in opposite
        directions.
    """
    left, right = sides.T
    return np.where(np.sign(left) * np.sign(right) < 0, left - right, 0)


BEST = 10.0


class MillipedeTravel(Fitness):
    """Motion in one direction, from 10 for the largest possible motion to −10 for its opposite.

    Other motions score 0: a turn, for example, if the direction is forward. The best leg angles are
    +20° for forward and −20° for backward; for a rotation, +20° on one side and −20° on the other.
    """

    direction: Literal["forward", "backward", "clockwise", "counter-clockwise"] = option(
        "forward", "direction of the motion that scores"
    )

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("side_reach",)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return one term, `travel`."""
        reach = motion["side_reach"]
        if self.direction in ("forward", "backward"):
            travel = BEST * forward_motion(reach)
        else:
            travel = BEST / 2 * clockwise_motion(reach)  # sides differ by up to 2
        opposite = self.direction in ("backward", "counter-clockwise")
        return {"travel": 0 - travel if opposite else travel}
