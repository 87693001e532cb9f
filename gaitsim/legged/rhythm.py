"""The stride of legs and the phases between them, computed from contacts for whole populations.

Sums are either of whole numbers or over one individual at a time, so that an individual's result
does not depend on the rest of the population.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Contacts = NDArray[np.bool_]

STEPS = 2  # touch-downs; a foot with fewer does not step
MOST = 0.5  # share of the feet; there is no stride if fewer step
CHATTER = 0.1  # share of a stride; shorter stances and swings are chatter
STEADY = 0.4  # smallest autocorrelation of a stride
EQUAL = 0.8  # share of the highest peak; the first peak above it is the stride, not a multiple


def touch_downs(stance: Contacts) -> Contacts:
    """Return whether each foot touches down in each frame, (population, frames, feet)."""
    downs = stance.copy()
    downs[:, 0] = False
    downs[:, 1:] &= ~stance[:, :-1]
    return downs


def stride_lag(stance: Contacts, frames: NDArray[np.intp]) -> tuple[NDArray[np.intp], Floats]:
    """Return the duration of a stride in whole frames, and the contacts' autocorrelation there.

    A stride is the first high peak of the autocorrelation, at a lag of at most half the motion.
    At least half of the feet must step.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        frames: number of frames that count, from the first, (population,).

    Returns:
        Both (population,); the duration is 0 for an individual without a stride.
    """
    steps = touch_downs(stance).sum(axis=1) >= STEPS
    correlation = _autocorrelation(stance, steps, frames)
    peak = np.zeros(correlation.shape, dtype=bool)
    inner = correlation[:, 2:-1]
    peak[:, 2:-1] = (inner >= correlation[:, 1:-2]) & (inner > correlation[:, 3:])
    peak &= np.arange(correlation.shape[1]) < (frames // 2)[:, None]
    height = np.where(peak, correlation, 0.0)
    highest = height.max(axis=1, initial=0.0)
    first = np.argmax(peak & (height >= EQUAL * highest[:, None]), axis=1)
    found = (highest >= STEADY) & (steps.mean(axis=1) >= MOST)
    return np.where(found, first, 0), correlation[np.arange(len(first)), first]


def without_chatter(stance: Contacts, stride: NDArray[np.intp]) -> Contacts:
    """Remove swings, and then stances, that are shorter than a tenth of a stride.

    The first and the last of each foot are kept, as they may be incomplete.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        stride: duration of a stride, frames, (population,); 0 removes nothing.
    """
    shortest = np.round(CHATTER * stride)[:, None]
    tidy = np.empty_like(stance)
    for foot in range(stance.shape[2]):
        tidy[..., foot] = ~_filled(~_filled(stance[..., foot], shortest), shortest)
    return tidy


def mean_stride(downs: Contacts, stride: NDArray[np.intp]) -> Floats:
    """Return the mean interval between touch-downs about a stride apart, (population,) frames.

    Args:
        downs: whether each foot touches down, (population, frames, feet).
        stride: duration of a stride, frames, (population,). Intervals of 0.5 to 1.5 strides count.
    """
    time = np.arange(downs.shape[1])
    total, count = np.zeros((2, len(downs)))
    for foot in range(downs.shape[2]):
        before = _latest(downs[..., foot])[:, :-1]
        interval = time[1:] - before
        chosen = downs[:, 1:, foot] & (before >= 0)
        chosen &= np.abs(interval - stride[:, None]) <= stride[:, None] / 2
        total += np.where(chosen, interval, 0).sum(axis=1)
        count += chosen.sum(axis=1)
    return np.divide(total, count, out=stride.astype(np.float64), where=count > 0)


def phase_after(downs: Contacts, pairs: Sequence[tuple[int, int]]) -> Floats:
    """Return the phase of touch-downs in the strides of other feet, cycles from 0 to 1.

    Args:
        downs: whether each foot touches down, (population, frames, feet).
        pairs: pairs of feet; the phase of the second in the strides of the first is measured.

    Returns:
        The circular mean over all strides and pairs, (population,); NaN without a stride.
    """
    population, frames, _ = downs.shape
    east, north, count = np.zeros((3, population))
    for one, other in pairs:
        begun, ends = _latest(downs[..., one]), _next(downs[..., one])
        who, when = np.nonzero(downs[..., other] & (begun >= 0) & (ends < frames))
        start, end = begun[who, when], ends[who, when]
        turn = 2 * np.pi * (when - start) / (end - start)
        east += np.bincount(who, np.cos(turn), population)
        north += np.bincount(who, np.sin(turn), population)
        count += np.bincount(who, minlength=population)
    cycles = (np.arctan2(north, east) / (2 * np.pi)) % 1.0
    return np.where(count > 0, np.where(cycles < 1 - 1e-9, cycles, 0.0), np.nan)


def _autocorrelation(stance: Contacts, steps: Contacts, frames: NDArray[np.intp]) -> Floats:
    """Return Pearson's autocorrelation of contacts, (population, lags).

    All stepping feet count together. Lags reach half of the frames.
    """
    population, length, feet = stance.shape
    lags = np.arange(length // 2 + 1)
    left = np.maximum(frames[:, None] - lags, 1)  # frames that overlap
    apart, now, later = np.zeros((3, population, len(lags)))
    power = np.zeros((population, length + 1))
    for foot in range(feet):  # one at a time, as transforms of all feet would need much memory
        touching = (stance[..., foot] & steps[:, [foot]]).astype(np.float64)
        spectrum = np.fft.rfft(touching, 2 * length, axis=1)
        power += spectrum.real**2 + spectrum.imag**2
        until = np.cumsum(np.pad(touching, ((0, 0), (1, 0))), axis=1)
        early = np.take_along_axis(until, left, axis=1)
        late = until[:, -1:] - until[:, lags]
        apart += early * late / left
        now += early - early**2 / left
        later += late - late**2 / left
    both = np.rint(np.fft.irfft(power, 2 * length, axis=1)[:, : len(lags)]) - apart
    scale = np.sqrt(np.maximum(now * later, 0.0))
    return np.divide(both, scale, out=np.zeros_like(both), where=scale > 0)


def _filled(stance: Contacts, shortest: NDArray[np.floating]) -> Contacts:
    """Fill gaps shorter than `shortest` between stances of a foot, (population, frames)."""
    before, after = _latest(stance), _next(stance)
    inner = (before >= 0) & (after < stance.shape[1])
    filled: Contacts = stance | (inner & (after - before - 1 < shortest))
    return filled


def _latest(event: Contacts) -> NDArray[np.intp]:
    """Return the frame of the latest event up to each frame, (population, frames); −1 for none."""
    return np.maximum.accumulate(np.where(event, np.arange(event.shape[1]), -1), axis=1)


def _next(event: Contacts) -> NDArray[np.intp]:
    """Return the frame of the next event after each frame; the number of frames for none."""
    frames = event.shape[1]
    found = np.full(event.shape, frames)
    ahead = np.where(event, np.arange(frames), frames)[:, ::-1]
    found[:, :-1] = np.minimum.accumulate(ahead, axis=1)[:, -2::-1]
    return found
