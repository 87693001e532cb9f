"""Round numbers for axes and grids."""

import math

import numpy as np
from numpy.typing import NDArray


def round_step(least: float) -> float:
    """Return the smallest of 1, 2 and 5 times a power of ten that is not below `least` > 0."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least * 0.999)


def ticks(low: float, high: float, most: int, *, whole: bool = False) -> NDArray[np.float64]:
    """Round numbers from `low` to `high`, at most `most` of them, in equal steps.

    Args:
        low: of the axis.
        high: of the axis, above it.
        most: how many there is room for.
        whole: only whole numbers.
    """
    step = round_step((high - low) / max(most, 1))
    if whole:
        step = max(step, 1.0)
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    found = np.arange(first, last + 1, dtype=np.float64) * step
    # One more can fit than there are steps in between.
    return found[:: 2 if len(found) > most > 1 else 1]


def labels(values: NDArray[np.float64]) -> list[str]:
    """Numbers as an axis says them, all with as many digits."""
    if not len(values):
        return []
    largest = float(np.abs(values).max())
    if largest >= 1e6 or 0 < largest < 1e-4:
        return [f"{value:.3g}".replace("-", "−") for value in values]
    digits = next(
        (digits for digits in range(6) if np.allclose(values, np.round(values, digits))), 6
    )
    return [f"{value:z,.{digits}f}".replace("-", "−") for value in values]
