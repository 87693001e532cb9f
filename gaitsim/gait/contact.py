"""Footfalls: the times and durations of the contacts of each foot with the ground."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gaitsim.legged.rhythm import CHATTER, MIN_TOUCH_DOWNS, stride_lag

Contacts = NDArray[np.bool_]
"""Whether each foot is on the ground until the next frame, (frames, feet)."""


@dataclass(frozen=True)
class Foot:
    """The steps of one foot.

    Attributes:
        name: name of the foot.
        duty_factor: share of the time on the ground, including chatter.
        touch_downs: frames in which the foot touches down, without chatter.
        stance, swing: mean duration of complete stances or swings, s; None if there are none.
    """

    name: str
    duty_factor: float
    touch_downs: tuple[int, ...]
    stance: float | None
    swing: float | None

    @property
    def steps(self) -> bool:
        """Whether the foot touches down more than once."""
        return len(self.touch_downs) >= MIN_TOUCH_DOWNS


@dataclass(frozen=True)
class Stride:
    """The stride of all feet.

    Attributes:
        frames: duration of a stride, frames.
        frequency: strides per second, Hz.
        periodicity: autocorrelation of the contacts at the lag of a stride; 1 if all strides are
            equal.
    """

    frames: float
    frequency: float
    periodicity: float


def feet_of(
    touching: Contacts, names: tuple[str, ...], frame_rate: float
) -> tuple[tuple[Foot, ...], Stride | None]:
    """Return the steps of each foot, and their common stride; None if they are not periodic."""
    lags, periodicity = stride_lag(touching[None], np.array([len(touching)]))
    lag = int(lags[0])
    shortest = max(1, round(CHATTER * lag))
    clean = np.stack([without_chatter(foot, shortest) for foot in touching.T], axis=1)
    feet = tuple(
        _foot(name, raw, tidy, frame_rate)
        for name, raw, tidy in zip(names, touching.T, clean.T, strict=True)
    )
    if not lag:
        return feet, None
    intervals = np.array([b - a for foot in feet for a, b in pairwise(foot.touch_downs)])
    near = intervals[np.abs(intervals - lag) <= lag / 2]
    frames = float(near.mean()) if len(near) else float(lag)
    return feet, Stride(frames, frame_rate / frames, float(periodicity[0]))


def runs(foot: Contacts) -> tuple[NDArray[np.intp], Contacts]:
    """Return the lengths of alternating stances and swings, frames, and a mask of the stances."""
    starts = np.flatnonzero(np.diff(foot)) + 1
    edges = np.concatenate([[0], starts, [len(foot)]])
    return np.diff(edges), foot[edges[:-1]]


def without_chatter(foot: Contacts, shortest: int) -> Contacts:
    """Remove stances and swings shorter than `shortest` frames, the shortest ones first.

    The first and the last one are kept, because they may be incomplete.
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
