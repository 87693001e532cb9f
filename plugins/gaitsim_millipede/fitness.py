"""The fitness `millipede-travel`: motion per cycle in one of four directions."""

from typing import ClassVar, Literal

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim_millipede.travel import clockwise_motion, forward_motion

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
