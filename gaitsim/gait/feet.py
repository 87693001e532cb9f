"""Feet: contacts with the ground, phases within a stride and their place on the body."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.legged.stepping import MIN_TOUCH_DOWNS, Steps

Floats = NDArray[np.float64]


def half_way(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the positions, (frames, …), in the middle of the interval after each frame."""
    exact = places.astype(np.float64)
    if len(exact) > 1:
        exact[:-1] = (exact[:-1] + exact[1:]) / 2
        exact[-1] = exact[-2]
    return exact


def steps(places: NDArray[np.floating[Any]]) -> Floats:
    """Return the horizontal distance moved, (frames − 1, …), by points, (frames, …, 3), m."""
    moved = np.diff(places[..., :2].astype(np.float64), axis=0)
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]))


Contacts = NDArray[np.bool_]
"""Whether each foot is on the ground until the next frame, (frames, feet)."""


@dataclass(frozen=True)
class Foot:
    """The steps of one foot.

    Attributes:
        name: name of the foot.
        duty_factor: share of the time in stance, without chatter for a body in physics.
        touch_downs: frames in which the foot touches down, without chatter.
        stance, swing: mean duration of complete stances or swings, s; None if there are none.
        touches: touches per stride, including chatter; None without a stride.
    """

    name: str
    duty_factor: float
    touch_downs: tuple[int, ...]
    stance: float | None
    swing: float | None
    touches: float | None = None

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
        commanded: whether the gait commands the frequency; if not, it is estimated.
    """

    frames: float
    frequency: float
    periodicity: float
    commanded: bool = False


def feet_of(
    touching: Contacts,
    names: tuple[str, ...],
    frame_rate: float,
    *,
    dynamic: bool = False,
    commanded: float = 0.0,
) -> tuple[tuple[Foot, ...], Stride | None]:
    """Return the steps of each foot, and their common stride; None if they are not periodic.

    Args:
        touching: whether each foot is on the ground.
        names: names of the feet.
        frame_rate: frames per second, Hz.
        dynamic: whether the body is simulated with forces, so that its feet can bounce.
        commanded: stride frequency that the gait commands, Hz; 0 if unknown.
    """
    [found] = feet_of_each(touching[None], names, frame_rate, dynamic, np.array([commanded]))
    return found


def feet_of_each(
    touching: Contacts,
    names: tuple[str, ...],
    frame_rate: float,
    dynamic: bool,
    commanded: Floats,
) -> list[tuple[tuple[Foot, ...], Stride | None]]:
    """Return for each individual what `feet_of` returns for one.

    Args:
        touching: whether each foot is on the ground, (population, frames, feet).
        names: names of the feet.
        frame_rate: frames per second, Hz.
        dynamic: whether the body is simulated with forces, so that its feet can bounce.
        commanded: stride frequencies that the gaits command, (population,) Hz; 0 if unknown.
    """
    population, frames, count = touching.shape
    found = Steps(touching, frame_rate, np.full(population, frames) if dynamic else None, commanded)
    downs = found.downs.transpose(0, 2, 1).reshape(-1, frames)
    landed = np.nonzero(downs)[1].tolist()
    ends = [0, *np.cumsum(downs.sum(axis=1)).tolist()]
    swings, stances = _mean_durations(found.stance)
    feet = [
        Foot(names[n % count], duty, tuple(landed[begin:end]), stance, swing, each)
        for n, (duty, (begin, end), stance, swing, each) in enumerate(
            zip(
                found.duty_factor.ravel().tolist(),
                pairwise(ends),
                _known(stances / frame_rate),
                _known(swings / frame_rate),
                _known(found.touches.ravel()),
                strict=True,
            )
        )
    ]
    strides = zip(found.period, found.frequency, found.regularity, commanded > 0, strict=True)
    return [
        (
            tuple(feet[index * count : (index + 1) * count]),
            Stride(float(period), float(frequency), float(regularity), bool(known))
            if period
            else None,
        )
        for index, (period, frequency, regularity, known) in enumerate(strides)
    ]


def _known(values: Floats) -> list[float | None]:
    """Return numbers, with None for NaN."""
    return [None if np.isnan(value) else value for value in values.tolist()]


def _mean_durations(stance: Contacts) -> Floats:
    """Return the mean duration of the swings, and of the stances, of each foot, frames.

    Only those count that begin and end within the motion.

    Args:
        stance: whether each foot is in stance, (population, frames, feet).

    Returns:
        The durations, (2, population · feet); NaN for a foot without any.
    """
    rows = stance.transpose(0, 2, 1).reshape(-1, stance.shape[1])
    row, begin = np.nonzero(rows[:, 1:] != rows[:, :-1])
    whole = row[1:] == row[:-1]
    kind = rows[row, begin + 1][:-1][whole] * len(rows) + row[:-1][whole]
    number = np.bincount(kind, minlength=2 * len(rows))
    total = np.bincount(kind, np.diff(begin)[whole], 2 * len(rows))
    means: Floats = np.divide(total, number, out=np.full(len(total), np.nan), where=number > 0)
    return means.reshape(2, -1)


def runs(foot: Contacts) -> tuple[NDArray[np.intp], Contacts]:
    """Return the lengths of alternating stances and swings, frames, and a mask of the stances."""
    starts = np.flatnonzero(np.diff(foot)) + 1
    edges = np.concatenate([[0], starts, [len(foot)]])
    return np.diff(edges), foot[edges[:-1]]


def phases_of(feet: tuple[Foot, ...], stride: Stride) -> tuple[Floats, Floats]:
    """Return the phase of each foot after the first foot that steps, and its consistency.

    Every touch-down is placed in the stride of the first foot, from one of its touch-downs to the
    next, as in Hildebrand (1965, Science 150:701). Before the first and after the last touch-down
    of that foot, strides have the mean length. If the gait commands the frequency, all strides have
    the commanded length.

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
    if stride.commanded:
        starts = starts[:1]
    stepping = [number for number, foot in enumerate(feet) if foot.steps]
    downs = [feet[number].touch_downs for number in stepping]
    times = np.array([*chain.from_iterable(downs)], dtype=np.float64)
    ends = np.cumsum([*map(len, downs)])
    directions = _directions(_strides_passed(times, starts, stride))
    mean = np.add.reduceat(directions, [0, *ends[:-1]]) / [*map(len, downs)]
    phases[stepping], consistency[stepping] = _phase(mean), np.abs(mean)
    if stride.commanded:
        phases = _wrap_to_cycle(phases - phases[feet.index(first)])
    elif len(starts) > 1:
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
    mean = _directions(cycles).mean()
    return float(_phase(mean)), float(abs(mean))


def _directions(cycles: ArrayLike) -> NDArray[np.complex128]:
    """Return unit vectors in the directions of angles in cycles."""
    directions: NDArray[np.complex128] = np.exp(2j * np.pi * np.asarray(cycles, dtype=np.float64))
    return directions


def _phase(vectors: Any) -> Floats:
    """Return the directions of vectors in cycles, 0 to 1."""
    return _wrap_to_cycle(np.angle(vectors) / (2 * np.pi))


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


_MIDDLE = 0.02  # largest distance from the midline of a foot on neither side, as a share of width


@dataclass(frozen=True, eq=False)
class Layout:
    """Feet in pairs.

    Attributes:
        pairs: number of pairs.
        side: side of each foot, (feet,): 0 left, 1 right.
        place: place of each foot, (feet,): 0 is the foremost on its side.
    """

    pairs: int
    side: NDArray[np.intp]
    place: NDArray[np.intp]


def in_body_frame(points: Floats, path: Floats, turned: Floats | None) -> Floats:
    """Return points over time, (frames, points, 3), relative to the body's position and heading."""
    away = points - path[:, None]
    if turned is None:
        return away
    cos, sin = np.cos(turned)[:, None], np.sin(turned)[:, None]
    return np.stack(
        [
            cos * away[..., 0] + sin * away[..., 1],
            cos * away[..., 1] - sin * away[..., 0],
            away[..., 2],
        ],
        axis=-1,
    )


def layout_of(feet: Floats) -> Layout | None:
    """Return the pairs of feet; None if the numbers of left and right feet differ.

    Args:
        feet: positions relative to the body, (frames, feet, 3), metres: x forward, y left.
    """
    return _layout(feet.mean(axis=0).astype(np.float64).tobytes())


@lru_cache(256)
def _layout(places: bytes) -> Layout | None:
    """Return the pairs of feet at mean places, float64 (feet, 3); an atlas has few."""
    x, y, _ = np.frombuffer(places).reshape(-1, 3).T
    width = np.abs(y).max(initial=0.0)
    left, right = np.flatnonzero(y > _MIDDLE * width), np.flatnonzero(y < -_MIDDLE * width)
    if not len(left) or len(left) != len(right) or len(left) + len(right) != len(x):
        return None
    side, place = np.zeros(len(x), dtype=np.intp), np.zeros(len(x), dtype=np.intp)
    for number, feet_of_side in enumerate((left, right)):
        side[feet_of_side] = number
        place[feet_of_side[np.argsort(-x[feet_of_side])]] = np.arange(len(left))
    return Layout(len(left), side, place)


def body_order(feet: Floats) -> NDArray[np.intp]:
    """Return the order of feet from left to right and front to back, (feet,): L1 L2 … R1 R2 …"""
    layout = layout_of(feet)
    if layout is None:
        return np.argsort(-feet.mean(axis=0)[:, 0], kind="stable")
    return np.lexsort((layout.place, layout.side))
