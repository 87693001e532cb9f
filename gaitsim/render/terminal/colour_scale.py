"""The colour scale of a heat map: the scores of its levels and the styles that draw them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.archive_view import colour_scale_low

AXIS, CURSOR, EMPTY = 1, 2, 3  # inks of axes and labels, of the cursor on the axes, of empty cells
LEVELS = 13  # levels of the scale; all pairs of levels, empty and cursor have inks in one byte
NONE, POINTED = 0, LEVELS + 1  # levels of an empty cell, and of the cell under the cursor
KINDS = LEVELS + 2
FIRST = 4
MARKED = FIRST + KINDS * KINDS

# Viridis, by Smith and van der Walt (2015), in equal steps.
VIRIDIS = (
    "#440154", "#481f70", "#443983", "#3b528b", "#31688e", "#287c8e", "#21918c",
    "#20a486", "#35b779", "#5ec962", "#90d743", "#c8e020", "#fde725",
)  # fmt: skip
POINTER = "#ff2d95"  # a colour absent from viridis, visible on dark and on light


@dataclass(frozen=True)
class Scale:
    """A linear scale from scores to levels of colour.

    Attributes:
        low: score at the low end of the scale.
        high: score at the high end of the scale.
        extended: whether some scores are below `low`.
    """

    low: float
    high: float
    extended: bool = False

    @classmethod
    def of(cls, scores: NDArray[np.float64]) -> "Scale":
        """Return the scale for scores, NaN if missing; a few very low scores may be below it."""
        known = scores[np.isfinite(scores)]
        if not len(known):
            return cls(0.0, 1.0)
        low, extended = colour_scale_low(known)
        return cls(low, float(known.max()), extended)

    def levels(self, scores: NDArray[np.float64], count: int) -> NDArray[np.intp]:
        """Return the level of each score, 1 to `count`; 0 for NaN."""
        share = (scores - self.low) / max(self.high - self.low, 1e-12)
        found = np.clip(np.nan_to_num(share * count, nan=0.0), 0, count - 1).astype(np.intp) + 1
        return np.where(np.isfinite(scores), found, NONE)


def ink_of(upper: int, lower: int) -> int:
    """Return the ink of a character whose halves have these levels."""
    return FIRST + upper * KINDS + lower


def styles(axis: str, empty: str, pointer: str = POINTER) -> list[str]:
    """Return the style of each ink as 'colour on background', in Rich's syntax.

    Args:
        axis: colour of axes and labels.
        empty: colour of empty cells.
        pointer: colour of the cursor.
    """
    levels = [*VIRIDIS, pointer]
    alone = ["", *levels]
    pairs = [
        f"{upper} on {lower}" if upper and lower else upper or lower
        for upper in alone
        for lower in alone
    ]
    dark, light = "bold #000000", "bold #ffffff"
    marked = [
        f"{dark if 2 * level > LEVELS else light} on {paint}"
        for level, paint in enumerate(levels, start=1)
    ]
    return [axis, axis, pointer, empty, *pairs, f"bold {axis}", *marked]
