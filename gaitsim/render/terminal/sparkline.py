"""Sparklines: curves in one line of block characters."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

BLOCKS = "▁▂▃▄▅▆▇█"


def sparkline(values: Sequence[float] | NDArray[np.float64], width: int) -> str:
    """Return a curve in at most `width` characters, with gaps where a value is not finite.

    A character that covers several values shows the last of them, so that the newest value is
    always visible. A flat curve is drawn at the bottom.
    """
    curve = np.asarray(values, dtype=np.float64)
    if width <= 0 or not len(curve):
        return ""
    if len(curve) > width:
        curve = curve[np.linspace(len(curve) / width - 1, len(curve) - 1, width).astype(int)]
    finite = np.isfinite(curve)
    if not finite.any():
        return " " * len(curve)
    # Halving keeps the difference of any two finite values finite.
    heights = np.where(finite, curve, curve[finite][0]) / 2
    heights -= heights.min()
    top = heights.max()
    steps = np.rint(heights / top * (len(BLOCKS) - 1) if top > 0 else heights).astype(int)
    return "".join(BLOCKS[at] if shown else " " for at, shown in zip(steps, finite, strict=True))
