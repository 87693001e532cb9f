"""Options for the worlds in which individuals are evaluated: number, ranges and redraws."""

from typing import Literal

from pydantic import BaseModel, ConfigDict

from gaitsim.contracts import option

WORLD = "world"
"""The option of a body that holds the conditions of its world."""


class Worlds(BaseModel):
    """Options for the worlds in which each individual is evaluated; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    number: int = option(
        0,
        "number of worlds, the same for all individuals, in which each one is evaluated; 0 uses "
        "only the world of the body's options. N worlds take N times as long, but count as one "
        "evaluation",
        ge=0,
        le=1000,
    )
    ranges: dict[str, tuple[float, float]] = option(
        {},
        "lowest and highest value of each condition that varies, by name; {} varies all conditions "
        "of the body over their usual ranges",
    )
    combine: Literal["mean", "worst", "worst tenth"] = option(
        "mean",
        "score of an individual: 'mean' is its mean score over all worlds, 'worst' its "
        "score in its worst world, 'worst tenth' its mean score over the worst tenth of "
        "its worlds",
    )
    redraw: int = option(
        0,
        "generations after which new worlds are drawn, and the best score is reset; 0 keeps the "
        "same worlds for the whole run",
        ge=0,
    )

    @property
    def own(self) -> "Worlds":
        """Options with only the body's own world; the ranges remain for unseen worlds."""
        return Worlds(ranges=self.ranges)

    @property
    def counted(self) -> int:
        """Number of an individual's worst worlds whose mean is its score."""
        share = {"mean": self.number, "worst": 1, "worst tenth": -(-self.number // 10)}
        return share[self.combine]

    def draw(self, generation: int) -> int:
        """Return the number of the draw of worlds for a generation, counted from 0."""
        return (generation - 1) // self.redraw if self.number and self.redraw else 0

    def first_of_draw(self, generation: int) -> int:
        """Return the first generation that is evaluated in the same worlds as `generation`."""
        return self.draw(generation) * self.redraw + 1

    def redraws(self, first: int, last: int) -> range:
        """Return the generations from `first` to `last` before which the worlds are redrawn."""
        if not (self.number and self.redraw):
            return range(0)
        first = max(first, 2)
        return range(first + (1 - first) % self.redraw, last + 1, self.redraw)

    def redrawn(self, generation: int) -> bool:
        """Return whether the worlds of a generation differ from those of the previous one."""
        return generation in self.redraws(generation, generation)


OWN_WORLD = Worlds()
