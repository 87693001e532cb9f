"""Options of the worlds that individuals are evaluated in: how many, their ranges, and redraws."""

from typing import Literal

from pydantic import BaseModel, ConfigDict

from gaitsim.contracts import option

WORLD = "world"
"""The option of a body with conditions that holds those of the world that it is in."""


class Worlds(BaseModel):
    """Worlds in which each individual is evaluated. Options, not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    number: int = option(
        0,
        "worlds in which each individual is evaluated, the same for all; 0 is the world of the "
        "body's options alone. An individual counts as one evaluation, but takes as many times "
        "as long",
        ge=0,
        le=1000,
    )
    ranges: dict[str, tuple[float, float]] = option(
        {},
        "lowest and highest value of each condition that varies, by name; none takes all "
        "conditions of the body with their usual ranges",
    )
    combine: Literal["mean", "worst", "worst tenth"] = option(
        "mean", "which of an individual's worlds count: their mean is its score"
    )
    redraw: int = option(
        0,
        "generations after which other worlds are drawn, and the best score begins anew; 0 keeps "
        "them for the whole run",
        ge=0,
    )

    @property
    def own(self) -> "Worlds":
        """The world of the body's options alone; the ranges stay, for unseen worlds."""
        return Worlds(ranges=self.ranges)

    @property
    def counted(self) -> int:
        """How many of an individual's worlds, its worst, its score is the mean of."""
        share = {"mean": self.number, "worst": 1, "worst tenth": -(-self.number // 10)}
        return share[self.combine]

    def draw(self, generation: int) -> int:
        """Return which draw of worlds a generation is evaluated in, from 0."""
        return (generation - 1) // self.redraw if self.number and self.redraw else 0

    def first_of_draw(self, generation: int) -> int:
        """Return the first generation that is evaluated in the same worlds as another one."""
        return self.draw(generation) * self.redraw + 1

    def redraws(self, first: int, last: int) -> range:
        """Return which generations, of those from first to last, begin a draw but the first one."""
        if not (self.number and self.redraw):
            return range(0)
        first = max(first, 2)
        return range(first + (1 - first) % self.redraw, last + 1, self.redraw)

    def redrawn(self, generation: int) -> bool:
        """Return whether a generation is evaluated in other worlds than the one before it."""
        return generation in self.redraws(generation, generation)


OWN_WORLD = Worlds()
