"""Round numbers and lengths, and their labels, for axes and grids."""

import math

import numpy as np
from numpy.typing import NDArray

UNITS = ((1.0, "m"), (0.01, "cm"), (0.001, "mm"))
"""Units of length for labels: size in metres and symbol, in descending order."""
MAX_VALUE = 1e300  # limit of values, so that the difference of two is finite


def format_round_length(metres: float) -> str:
    """Format a round length in the largest unit in which it is 1 or more, such as '20 cm'."""
    size, unit = next((one for one in UNITS if metres >= one[0] * 0.999), UNITS[-1])
    return f"{metres / size:g} {unit}"


def round_step(least: float) -> float:
    """Return the smallest number of the form 1, 2 or 5 × 10ⁿ that is at least `least` > 0."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least * 0.999)


def ticks(low: float, high: float, most: int, *, whole: bool = False) -> NDArray[np.float64]:
    """Return round numbers from `low` to `high` in equal steps.

    Args:
        low: low end of the axis.
        high: high end of the axis, greater than `low`.
        most: maximum number of ticks.
        whole: whether to return only whole numbers.
    """
    step = round_step((high - low) / max(most, 1))
    if whole:
        step = max(step, 1.0)
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    found = np.arange(first, last + 1, dtype=np.float64) * step
    # There can be one more tick than steps.
    return found[:: 2 if len(found) > most > 1 else 1]


def clipped(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values clipped so that the difference of two is finite; NaN for infinite ones."""
    return np.where(np.isfinite(values), np.clip(values, -MAX_VALUE, MAX_VALUE), np.nan)


def ends_of(values: NDArray[np.float64], margin: float = 0.0) -> tuple[float, float]:
    """Return the ends of an axis for values; values that are all equal are in its middle.

    Args:
        values: values, of which those that are not finite are ignored.
        margin: empty share of the axis beyond the outermost values.
    """
    known = clipped(values[np.isfinite(values)])
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    if high - low <= max(1e-9 * max(abs(low), abs(high)), 1e-300):
        half = 0.1 * abs(low) or 1.0
        return low - half, high + half
    return low - margin * (high - low), high + margin * (high - low)


def labels(values: NDArray[np.float64]) -> list[str]:
    """Format numbers for an axis, with the same number of decimals."""
    if not len(values):
        return []
    largest = float(np.abs(values).max())
    gap = float(np.diff(values).min()) if len(values) > 1 else largest
    if (largest >= 1e6 or 0 < largest < 1e-4) and gap >= largest / 100:
        return [_short(value) for value in values.tolist()]
    digits = next(
        (n for n in range(13) if np.abs(values - np.round(values, n)).max() <= 1e-3 * gap), 13
    )
    return [f"{value:z,.{digits}f}".replace("-", "−") for value in values]


def _short(value: float) -> str:
    """Format a number with three digits and a power of ten, such as 1.5e8 or −2e−5."""
    digits, exponent, power = f"{value:.3g}".partition("e")
    return (digits + (f"e{int(power)}" if exponent else "")).replace("-", "−")
