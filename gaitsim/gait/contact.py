"""Footfalls: when each foot is on the ground, and how long."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.intervals import Floats

Contacts = NDArray[np.bool_]
"""(frames, feet): which feet are on the ground until the next frame."""

_STEPS = 2  # touch-downs: with fewer, a foot does not step
_MOST = 0.5  # of the feet: if fewer step, the body has no stride
_CHATTER = 0.1  # of a stride: shorter stances and swings are chatter
_STEADY = 0.4  # autocorrelation from which there is a stride
_EQUAL = 0.8  # of the highest peak: the first that is as high is the stride, not a multiple of it


@dataclass(frozen=True)
class Foot:
    """The steps of one foot.

    Attributes:
        name: of the foot.
        duty_factor: share of the time on the ground, including chatter.
        touch_downs: frames in which it touches down, without chatter.
        stance, swing: mean duration of complete stances and swings, s; None where there are
            none.
    """

    name: str
    duty_factor: float
    touch_downs: tuple[int, ...]
    stance: float | None
    swing: float | None

    @property
    def steps(self) -> bool:
        """Whether it touches down more than once."""
        return len(self.touch_downs) >= _STEPS


@dataclass(frozen=True)
class Stride:
    """The stride of all feet.

    Attributes:
        frames: duration of a stride.
        frequency: strides a second, Hz.
        periodicity: autocorrelation of the contacts at a stride's distance, 1 where every
            stride is the same.
    """

    frames: float
    frequency: float
    periodicity: float


def feet_of(
    touching: Contacts, names: tuple[str, ...], frame_rate: float
) -> tuple[tuple[Foot, ...], Stride | None]:
    """Return the steps of each foot and their common stride; None where there is none."""
    lag, periodicity = _autocorrelation_peak(touching)
    shortest = max(1, round(_CHATTER * lag)) if lag else 1
    clean = np.stack([without_chatter(foot, shortest) for foot in touching.T], axis=1)
    feet = tuple(
        _foot(name, raw, tidy, frame_rate)
        for name, raw, tidy in zip(names, touching.T, clean.T, strict=True)
    )
    if lag is None:
        return feet, None
    intervals = np.array([b - a for foot in feet for a, b in pairwise(foot.touch_downs)])
    near = intervals[np.abs(intervals - lag) <= lag / 2]
    frames = float(near.mean()) if len(near) else float(lag)
    return feet, Stride(frames, frame_rate / frames, periodicity)


def runs(foot: Contacts) -> tuple[NDArray[np.intp], Contacts]:
    """Return the lengths of alternating stances and swings, frames, and which are stances."""
    starts = np.flatnonzero(np.diff(foot)) + 1
    edges = np.concatenate([[0], starts, [len(foot)]])
    return np.diff(edges), foot[edges[:-1]]


def without_chatter(foot: Contacts, shortest: int) -> Contacts:
    """Remove stances and swings of fewer frames, the shortest ones first.

    The first and the last one stay, as they may be incomplete.
    """
    tidy = foot.copy()
    while True:
        lengths, _ = runs(tidy)
        inner = lengths[1:-1]
        if not len(inner) or inner.min() >= shortest:
            return tidy
        first = int(np.argmin(inner)) + 1
        start = int(lengths[:first].sum())
        tidy[start : start + lengths[first]] ^= True


def _foot(name: str, raw: Contacts, tidy: Contacts, frame_rate: float) -> Foot:
    lengths, stance = runs(tidy)
    whole = np.zeros(len(lengths), dtype=bool)
    whole[1:-1] = True
    touch_downs = np.flatnonzero(~tidy[:-1] & tidy[1:]) + 1

    def mean(chosen: Contacts) -> float | None:
        return float(lengths[chosen].mean()) / frame_rate if chosen.any() else None

    return Foot(
        name,
        float(raw.mean()),
        tuple(touch_downs.tolist()),
        mean(whole & stance),
        mean(whole & ~stance),
    )


def _autocorrelation_peak(touching: Contacts) -> tuple[int | None, float]:
    """Return the stride in frames and the autocorrelation of the contacts there.

    Sums over the feet that touch down at least twice, if they are half of them. The stride is
    the first peak within half of the frames that is nearly as high as the highest one.
    """
    downs = (np.diff(touching.astype(np.int8), axis=0) > 0).sum(axis=0)
    stepping = downs >= _STEPS
    contacts = touching[:, stepping].astype(np.float64)
    half = len(contacts) // 2
    if stepping.mean() < _MOST or half < 3:
        return None, 0.0
    correlation = _correlations(contacts, half)
    inner = correlation[1:-1]
    peaks = np.flatnonzero((inner >= correlation[:-2]) & (inner > correlation[2:])) + 1
    peaks = peaks[peaks > 1]
    if not len(peaks) or correlation[peaks].max() < _STEADY:
        return None, float(correlation[peaks].max(initial=0.0))
    high = peaks[correlation[peaks] >= _EQUAL * correlation[peaks].max()]
    return int(high[0]), float(correlation[high[0]])


def _correlations(contacts: Floats, most: int) -> Floats:
    """Return Pearson's correlation of all feet with themselves up to `most` frames later.

    Args:
        contacts: 0 or 1, (frames, feet).
        most: frames later.

    Returns:
        (most + 1,); 0 where a foot never changes.
    """
    frames = len(contacts)
    # By FFT: 0.1 ms rather than 5 ms. Products of zeros and ones are counts, so they are exact.
    spectrum = np.fft.rfft(contacts, 2 * frames, axis=0)
    both = np.rint(np.fft.irfft(np.abs(spectrum) ** 2, axis=0)[: most + 1])
    count = frames - np.arange(most + 1)[:, None]
    sums = np.concatenate([np.zeros_like(contacts[:1]), np.cumsum(contacts, axis=0)])
    now, later = sums[frames - np.arange(most + 1)], sums[-1] - sums[: most + 1]
    products = (both - now * later / count).sum(axis=1)
    scale = np.sqrt((now - now**2 / count).sum(axis=1) * (later - later**2 / count).sum(axis=1))
    return np.asarray(np.divide(products, scale, np.zeros_like(products), where=scale > 1e-9))
