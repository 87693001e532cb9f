"""The fitness `millipede-travel`: motion in a cycle in one of four directions."""

from typing import ClassVar, Literal

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim_millipede.travel import clockwise, forward

BEST = 10.0


class MillipedeTravel(Fitness):
    """Motion in one direction, from 10 for the largest possible to −10 for its opposite.

    Motion of another kind scores 0, as a turn does for forward. The best legs stand at
    +20° for forward, −20° for backward; for a rotation +20° on one side, −20° on the other.
    """

    direction: Literal["forward", "backward", "clockwise", "counter-clockwise"] = option(
        "forward", "the motion that scores"
    )

    needs: ClassVar[tuple[str, ...]] = ("side_reach",)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """One term, `travel`."""
        reach = motion["side_reach"]
        if self.direction in ("forward", "backward"):
            travel = BEST * forward(reach)
        else:
            travel = BEST / 2 * clockwise(reach)  # sides differ by up to 2
        opposite = self.direction in ("backward", "counter-clockwise")
        return {"travel": 0 - travel if opposite else travel}
