"""Measures of the steps of legs, for whole populations."""

from collections.abc import Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Measure
from gaitsim.portable import arctan2, cos, sin

Floats = NDArray[np.float64]
Contacts = NDArray[np.bool_]

MIN_TOUCH_DOWNS = 2  # a foot with fewer touch-downs does not step
MIN_STEPPING = 0.5  # share of the feet; there is no stride if fewer step
CHATTER = 0.1  # share of a stride; shorter stances and swings are chatter
MIN_AUTOCORRELATION = 0.4  # smallest autocorrelation at the lag of a stride
PEAK_SHARE = 0.8  # the first peak of at least this share of the highest peak is the stride


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
        frames: number of frames to use, from the first, (population,).

    Returns:
        Durations and autocorrelations, (population,) each; the duration is 0 for an individual
        without a stride.
    """
    steps = touch_downs(stance).sum(axis=1) >= MIN_TOUCH_DOWNS
    correlation = _autocorrelation(stance, steps, frames)
    peak = np.zeros(correlation.shape, dtype=bool)
    inner = correlation[:, 2:-1]
    peak[:, 2:-1] = (inner >= correlation[:, 1:-2]) & (inner > correlation[:, 3:])
    peak &= np.arange(correlation.shape[1]) < (frames // 2)[:, None]
    height = np.where(peak, correlation, 0.0)
    highest = height.max(axis=1, initial=0.0)
    first = np.argmax(peak & (height >= PEAK_SHARE * highest[:, None]), axis=1)
    found = (highest >= MIN_AUTOCORRELATION) & (steps.mean(axis=1) >= MIN_STEPPING)
    return np.where(found, first, 0), correlation[np.arange(len(first)), first]


def without_chatter(stance: Contacts, stride: NDArray[np.intp]) -> Contacts:
    """Remove swings, and then stances, that are shorter than a tenth of a stride.

    The first and the last phase of each foot are kept, as they may be incomplete.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        stride: duration of a stride, frames, (population,); 0 removes nothing.
    """
    shortest = np.round(CHATTER * stride)[:, None]
    tidy = np.empty_like(stance)
    for foot in range(stance.shape[2]):
        tidy[..., foot] = ~_fill_gaps(~_fill_gaps(stance[..., foot], shortest), shortest)
    return tidy


def mean_stride(downs: Contacts, stride: NDArray[np.intp]) -> Floats:
    """Return the mean duration of a stride, (population,) frames.

    It is the mean interval between successive touch-downs of a foot, counting only intervals of
    0.5 to 1.5 times `stride`. Without such intervals it is `stride`.

    Args:
        downs: whether each foot touches down, (population, frames, feet).
        stride: duration of a stride in whole frames, (population,).
    """
    time = np.arange(downs.shape[1])
    total, count = np.zeros((2, len(downs)))
    for foot in range(downs.shape[2]):
        before = _last_event(downs[..., foot])[:, :-1]
        interval = time[1:] - before
        chosen = downs[:, 1:, foot] & (before >= 0)
        chosen &= np.abs(interval - stride[:, None]) <= stride[:, None] / 2
        total += np.where(chosen, interval, 0).sum(axis=1)
        count += chosen.sum(axis=1)
    return np.divide(total, count, out=stride.astype(np.float64), where=count > 0)


def phase_lag(downs: Contacts, pairs: Sequence[tuple[int, int]]) -> Floats:
    """Return the phase of touch-downs in the strides of other feet, cycles from 0 to 1.

    Args:
        downs: whether each foot touches down, (population, frames, feet).
        pairs: pairs of feet; the second foot touches down in the strides of the first.

    Returns:
        The circular mean over all strides and pairs, (population,); NaN without a stride.
    """
    population, frames, _ = downs.shape
    east, north, count = np.zeros((3, population))
    for one, other in pairs:
        starts, ends = _last_event(downs[..., one]), _next_event(downs[..., one])
        individual, frame = np.nonzero(downs[..., other] & (starts >= 0) & (ends < frames))
        start, end = starts[individual, frame], ends[individual, frame]
        angle = 2 * np.pi * (frame - start) / (end - start)
        east += np.bincount(individual, cos(angle), population)
        north += np.bincount(individual, sin(angle), population)
        count += np.bincount(individual, minlength=population)
    cycles = (arctan2(north, east) / (2 * np.pi)) % 1.0
    return np.where(count > 0, np.where(cycles < 1 - 1e-9, cycles, 0.0), np.nan)


def _autocorrelation(stance: Contacts, steps: Contacts, frames: NDArray[np.intp]) -> Floats:
    """Return Pearson's autocorrelation of contacts, (population, lags), over all stepping feet.

    The lags are 0 to half the number of frames.
    """
    population, length, feet = stance.shape
    lags = np.arange(length // 2 + 1)
    overlap = np.maximum(frames[:, None] - lags, 1)  # frames
    product, now, later = np.zeros((3, population, len(lags)))
    power = np.zeros((population, length + 1))
    for foot in range(feet):  # one at a time, as transforms of all feet would need much memory
        touching = (stance[..., foot] & steps[:, [foot]]).astype(np.float64)
        spectrum = np.fft.rfft(touching, 2 * length, axis=1)  # noqa: TID251 (see below)
        power += np.square(spectrum.real) + np.square(spectrum.imag)
        until = np.cumsum(np.pad(touching, ((0, 0), (1, 0))), axis=1)
        early = np.take_along_axis(until, overlap, axis=1)
        late = until[:, -1:] - until[:, lags]
        product += early * late / overlap
        now += early - np.square(early) / overlap
        later += late - np.square(late) / overlap
    # The transforms count contacts; rounded to whole numbers, they are the same everywhere.
    counts = np.rint(np.fft.irfft(power, 2 * length, axis=1)[:, : len(lags)])  # noqa: TID251
    covariance = counts - product
    scale = np.sqrt(np.maximum(now * later, 0.0))
    return np.divide(covariance, scale, out=np.zeros_like(covariance), where=scale > 0)


def _fill_gaps(stance: Contacts, shortest: NDArray[np.floating]) -> Contacts:
    """Fill gaps that are shorter than `shortest` between stances, (population, frames)."""
    before, after = _last_event(stance), _next_event(stance)
    inner = (before >= 0) & (after < stance.shape[1])
    filled: Contacts = stance | (inner & (after - before - 1 < shortest))
    return filled


def _last_event(event: Contacts) -> NDArray[np.intp]:
    """Return the frame of the last event up to each frame, (population, frames); −1 for none."""
    return np.maximum.accumulate(np.where(event, np.arange(event.shape[1]), -1), axis=1)


def _next_event(event: Contacts) -> NDArray[np.intp]:
    """Return the frame of the next event after each frame; the number of frames for none."""
    frames = event.shape[1]
    found = np.full(event.shape, frames)
    ahead = np.where(event, np.arange(frames), frames)[:, ::-1]
    found[:, :-1] = np.minimum.accumulate(ahead, axis=1)[:, -2::-1]
    return found


DUTY = "duty factor"
BODY_HEIGHT = "body height"


def stepping_measures(
    stance: NDArray[np.bool_],
    legs: Sequence[str],
    frame_rate: float,
    *,
    sides: Sequence[Sequence[str]] = (),
    upright: NDArray[np.intp] | None = None,
) -> dict[str, Measure]:
    """Return measures of the steps of legs.

    - `duty factor`: mean share of the time that a foot is on the ground (Alexander 1984, "The gaits
      of bipedal and quadrupedal animals"). Each foot also has its own measure, such as
      'duty factor L1'.
    - `stride frequency`: strides per second; 0 without a stride (see `rhythm.stride_lag`).
    - `phase lag`: phase at which a foot touches down in the stride of the foot in front of it on
      the same side, in cycles from 0 to 1 (Hildebrand 1965, "Symmetrical gaits of horses"). This is
      the circular mean over all strides and pairs; NaN without a stride. Only with `sides`.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet), in the order of
            `legs`.
        legs: names of the legs.
        frame_rate: frames per second, Hz.
        sides: names of the legs on each side, front to back.
        upright: number of frames before each individual's fall, (population,); None if no
            individual falls.
    """
    steps = _Steps(stance, frame_rate, upright)
    pairs = [
        (legs.index(front), legs.index(rear)) for side in sides for front, rear in pairwise(side)
    ]
    mean = Measure(
        steps.mean, "", "share of the time that a foot is on the ground, averaged over the feet"
    )
    frequency = Measure(steps.frequency, "Hz", "strides per second; 0 without a stride")
    lag = Measure(
        partial(steps.lag, pairs),
        "cycles",
        "mean phase of a foot's touch-downs in the stride of the next foot in front of it",
    )
    return {
        DUTY: mean,
        **{
            f"{DUTY} {name}": Measure(
                partial(steps.duty_factor, leg),
                "",
                f"share of the time that the foot of {name} is on the ground",
            )
            for leg, name in enumerate(legs)
        },
        "stride frequency": frequency,
        **({"phase lag": lag} if pairs else {}),
    }


class _Steps:
    """Values from which the measures are computed, cached."""

    def __init__(
        self, stance: NDArray[np.bool_], frame_rate: float, upright: NDArray[np.intp] | None
    ) -> None:
        self._contacts, self._frame_rate, self._upright = stance, frame_rate, upright

    @cached_property
    def _frames(self) -> NDArray[np.intp]:
        population, frames, _ = self._contacts.shape
        return np.full(population, frames) if self._upright is None else self._upright

    @cached_property
    def _stance(self) -> NDArray[np.bool_]:
        if self._upright is None:
            return self._contacts
        before = np.arange(self._contacts.shape[1]) < self._upright[:, None]
        return self._contacts & before[..., None]

    @cached_property
    def _stride(self) -> NDArray[np.intp]:
        return stride_lag(self._stance, self._frames)[0]

    @cached_property
    def _downs(self) -> NDArray[np.bool_]:
        return touch_downs(without_chatter(self._stance, self._stride))

    @cached_property
    def _shares(self) -> Floats:
        return np.asarray(self._stance.sum(axis=1) / self._frames[:, None])

    def mean(self) -> Floats:
        return np.asarray(self._shares.mean(axis=1))

    def duty_factor(self, leg: int) -> Floats:
        return self._shares[:, leg]

    def frequency(self) -> Floats:
        frames = mean_stride(self._downs, self._stride)
        return np.divide(self._frame_rate, frames, out=np.zeros(len(frames)), where=frames > 0)

    def lag(self, pairs: Sequence[tuple[int, int]]) -> Floats:
        return np.where(self._stride > 0, phase_lag(self._downs, pairs), np.nan)
