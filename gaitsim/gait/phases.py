"""Phases of the feet within a stride: circular means and their consistency."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.gait.contact import Foot, Stride
from gaitsim.gait.intervals import Floats


def phases_of(feet: tuple[Foot, ...], stride: Stride) -> tuple[Floats, Floats]:
    """Return the phase of each foot after the first foot that steps, and its consistency.

    Every touch-down is placed in the stride of the first foot, from one of its touch-downs to the
    next, as in Hildebrand (1965, Science 150:701). Before the first and after the last touch-down
    of that foot, strides have the mean length.

    Args:
        feet: steps of each foot; the first foot that steps is the reference.
        stride: common stride, with its mean length.

    Returns:
        The phases, (feet,), circular means in cycles from 0 to 1, and the lengths of the mean
        vectors, (feet,): 1 if the phase is the same in every stride, near 0 if it is random. Both
        are NaN for feet that do not step.
    """
    phases, consistency = np.full((2, len(feet)), np.nan)
    first = next((foot for foot in feet if foot.steps), None)
    if first is None:
        return phases, consistency
    starts = np.array(first.touch_downs, dtype=np.float64)
    for number, foot in enumerate(feet):
        if foot.steps:
            passed = _strides_passed(np.array(foot.touch_downs, dtype=np.float64), starts, stride)
            phases[number], consistency[number] = circular_mean(passed)
    if len(starts) > 1:
        # A foot is always in phase with itself, so use the regularity of its strides instead.
        even = starts / stride.frames
        consistency[feet.index(first)] = circular_mean(even - np.arange(len(even)))[1]
    return phases, consistency


def _strides_passed(times: Floats, starts: Floats, stride: Stride) -> Floats:
    """Return the number of strides, which start at `starts`, that have passed at `times`."""
    passed = np.interp(times, starts, np.arange(len(starts), dtype=np.float64))
    passed += np.minimum(times - starts[0], 0) / stride.frames
    passed += np.maximum(times - starts[-1], 0) / stride.frames
    return np.asarray(passed)


def circular_mean(cycles: ArrayLike) -> tuple[float, float]:
    """Return the mean direction of angles in cycles, 0 to 1, and the length of the mean vector."""
    mean = np.exp(2j * np.pi * np.asarray(cycles, dtype=np.float64)).mean()
    return float(_wrap_to_cycle(np.angle(mean) / (2 * np.pi))), float(abs(mean))


def _wrap_to_cycle(cycles: ArrayLike) -> Floats:
    """Wrap phases to 0 to 1; a phase just below 1, due to rounding, becomes 0."""
    phases = np.asarray(cycles, dtype=np.float64) % 1.0
    return np.where(phases < 1 - 1e-9, phases, 0.0)


def wrap(cycles: NDArray[np.float64]) -> Floats:
    """Wrap differences in cycles to −½ to ½."""
    return np.asarray((cycles + 0.5) % 1.0 - 0.5)


def fit(phases: Floats, patterns: Floats) -> tuple[Floats, Floats]:
    """Return the rms circular distance of phases to patterns in cycles, and the shifted patterns.

    The distance is the exact minimum over all common shifts. On a circle, the differences have one
    candidate mean per foot, and the best shift is one of these (Hotz and Huckemann 2015,
    "Intrinsic means on the circle").

    Args:
        phases: phase of each foot, (feet,), cycles; feet with NaN are ignored.
        patterns: phases of the patterns, (..., feet), cycles.

    Returns:
        The distances, (...), and the shifted patterns, (..., feet), from 0 to 1.
    """
    known = ~np.isnan(phases)
    away = np.sort((phases - patterns)[..., known] % 1.0, axis=-1)
    count = away.shape[-1]
    # The mean of the differences if the first k of them are taken one cycle later.
    k = np.arange(count)
    before = np.cumsum(away, axis=-1) - away
    means = (away.sum(axis=-1, keepdims=True) + k) / count
    squares = ((away**2).sum(axis=-1, keepdims=True) + 2 * before + k) / count
    best = np.argmin(squares - means**2, axis=-1)[..., None]
    shift = np.take_along_axis(means, best, axis=-1)
    distances = np.sqrt((wrap(away - shift) ** 2).mean(axis=-1))
    return distances, _wrap_to_cycle(patterns + shift)
