"""Measures of the steps of legs, for whole populations."""

from collections.abc import Sequence
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Channel, Measure
from gaitsim.portable import arctan2, cos, sin

Floats = NDArray[np.float64]
Contacts = NDArray[np.bool_]

DUTY = "duty factor"
BODY_HEIGHT = "body height"
STRIDE_FREQUENCY = "stride_frequency"
STRIDE_FREQUENCY_CHANNEL = Channel(
    (), "Hz", "strides per second that the gait commands; 0 if unknown"
)
"""Channel of a legged body, in which the analysis of a gait looks for its stride frequency."""

MIN_TOUCH_DOWNS = 2  # a foot with fewer touch-downs does not step
MIN_STEPPING = 0.5  # share of the feet; there is no stride if fewer step
CHATTER = 0.1  # share of a stride; shorter stances and swings are chatter
MIN_AUTOCORRELATION = 0.4  # smallest autocorrelation at the lag of a stride
MIN_MOTION = 0.1  # share of the largest range; joints that move less do not show the stride
PEAK_SHARE = 0.8  # the first peak of at least this share of the highest peak is the stride


def touch_downs(stance: Contacts) -> Contacts:
    """Return whether each foot touches down in each frame, (population, frames, feet)."""
    downs = stance.copy()
    downs[:, 0] = False
    downs[:, 1:] &= ~stance[:, :-1]
    return downs


def estimate_period(correlation: Floats, frames: NDArray[np.intp]) -> Floats:
    """Return the duration of a stride, (population,) frames; 0 without a stride.

    A stride is the first high peak of the autocorrelation, at a lag of at most half the motion. Of
    all durations within a frame of it, the one whose multiples have the highest mean
    autocorrelation is chosen.

    Args:
        correlation: autocorrelation of the contacts, (population, lags).
        frames: number of frames in use, (population,).
    """
    peak = np.zeros(correlation.shape, dtype=bool)
    inner = correlation[:, 2:-1]
    peak[:, 2:-1] = (inner >= correlation[:, 1:-2]) & (inner > correlation[:, 3:])
    peak &= np.arange(correlation.shape[1]) < (frames // 2)[:, None]
    height = np.where(peak, correlation, 0.0)
    highest = height.max(axis=1, initial=0.0)
    first = np.argmax(peak & (height >= PEAK_SHARE * highest[:, None]), axis=1)
    period = np.where(highest >= MIN_AUTOCORRELATION, first, 0).astype(np.float64)
    for row in np.flatnonzero(period):
        count = int(frames[row] // 2 // (first[row] + 1))  # at least 1
        multiples = np.arange(1, count + 1)[:, None]
        tried = first[row] + np.arange(-3 * count, 3 * count + 1) / (3 * count)
        at = np.rint(multiples * tried).astype(np.intp)
        mean = np.cumsum(correlation[row, at], axis=0)[-1]
        best = np.flatnonzero(mean == mean.max())
        period[row] = tried[best[len(best) // 2]]
    return period


def without_chatter(stance: Contacts, stride: NDArray[Any]) -> Contacts:
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


def one_stance_per_stride(stance: Contacts, period: Floats) -> Contacts:
    """Keep one stance of each foot in each stride, however often the foot touches the ground.

    The strides of a foot are separated half a cycle after the mean phase of its contacts. The
    stance of a stride is the interval with the largest sum of s + p − 1, where s is 1 on the ground
    and 0 in the air, and p is the mean of s at the same phase of all strides. So it spans losses of
    contact where the foot usually stands, and leaves out short touches.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        period: duration of a stride, frames, (population,).
    """
    from gaitsim.portable.intervals import mark_largest_intervals

    population, frames, feet = stance.shape
    course = np.arange(frames) / period[:, None]  # cycles
    east, north = cos(2 * np.pi * course), sin(2 * np.pi * course)
    bins = np.maximum(np.rint(period), 1.0)  # about a frame each
    phase = (np.rint(course * bins[:, None]) % bins[:, None]).astype(np.intp)
    phase += int(bins.max(initial=1.0)) * np.arange(population)[:, None]
    count = np.bincount(phase.ravel())
    single = np.zeros_like(stance)
    for foot in range(feet):
        touching = stance[..., foot]
        middle = arctan2((touching * north).sum(axis=1), (touching * east).sum(axis=1))
        stride = np.floor(course - (middle / (2 * np.pi) - 0.5)[:, None])
        share = np.bincount(phase.ravel(), touching.ravel()) / np.maximum(count, 1)
        # Sums of sixteenths are exact.
        worth = touching - 1 + np.rint(16 * share)[phase] / 16
        mark_largest_intervals(worth, stride, single[..., foot])
    return single


def autocorrelation(stance: Contacts, frames: NDArray[np.intp]) -> Floats:
    """Return Pearson's autocorrelation of contacts over all feet that step, (population, lags).

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        frames: number of frames to use, from the first, (population,).

    Returns:
        The autocorrelation at lags from 0 to half the number of frames.
    """
    steps = touch_downs(stance).sum(axis=1) >= MIN_TOUCH_DOWNS
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


class Steps:
    """The steps of a population, without chatter.

    With a known stride frequency, each foot has at most one stance in each stride. Without, the
    frequency is estimated from the contacts, and only short stances and swings are removed.

    Feet bounce on bodies in physics. A kinematic body touches the ground exactly as its gait
    commands, so its duty factors include short contacts.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet).
        frame_rate: frames per second, Hz.
        upright: number of frames before each individual's fall, (population,); None for a
            kinematic body, which does not fall.
        commanded: stride frequency that the gait commands, (population,) Hz, 0 if unknown; None if
            it is unknown for all individuals.
    """

    def __init__(
        self,
        stance: Contacts,
        frame_rate: float,
        upright: NDArray[np.intp] | None = None,
        commanded: Floats | None = None,
    ) -> None:
        population, frames, _ = stance.shape
        self._frame_rate = frame_rate
        self._frames = np.full(population, frames) if upright is None else upright
        self._contacts = stance & (np.arange(frames) < self._frames[:, None])[..., None]
        self._bounces = upright is not None
        self._commanded = np.zeros(population) if commanded is None else commanded
        self._known = self._commanded > 0

    @cached_property
    def _correlation(self) -> Floats:
        return autocorrelation(self._contacts, self._frames)

    @cached_property
    def _stride(self) -> Floats:
        """Commanded or estimated duration of a stride, (population,) frames; 0 if unknown."""
        if self._known.all():
            return self._frame_rate / self._commanded
        stride = estimate_period(self._correlation, self._frames)
        np.divide(self._frame_rate, self._commanded, out=stride, where=self._known)
        return stride

    @cached_property
    def stance(self) -> Contacts:
        """Whether each foot is in stance, (population, frames, feet)."""
        single = self._contacts.copy()
        known = self._known
        single[known] = one_stance_per_stride(self._contacts[known], self._stride[known])
        return without_chatter(single, self._stride)

    @cached_property
    def downs(self) -> Contacts:
        """Whether each foot begins a stance in each frame, (population, frames, feet)."""
        return touch_downs(self.stance)

    @cached_property
    def period(self) -> Floats:
        """Duration of a stride, (population,) frames; 0 if fewer than half of the feet step."""
        steps = self.downs.sum(axis=1) >= MIN_TOUCH_DOWNS
        return np.where(steps.mean(axis=1) >= MIN_STEPPING, self._stride, 0.0)

    @cached_property
    def frequency(self) -> Floats:
        """Strides per second, (population,) Hz; 0 if fewer than half of the feet step."""
        stride, found = self.period > 0, np.zeros(len(self.period))
        np.divide(self._frame_rate, self.period, out=found, where=stride)
        return np.where(self._known & stride, self._commanded, found)

    @cached_property
    def regularity(self) -> Floats:
        """Autocorrelation of the contacts at the duration of a stride, (population,)."""
        lags = np.rint(self.period).astype(np.intp)
        last = self._correlation.shape[1] - 1
        return np.asarray(self._correlation[np.arange(len(lags)), np.minimum(lags, last)])

    @cached_property
    def duty_factor(self) -> Floats:
        """Share of the time that each foot is in stance, (population, feet)."""
        counted = self.stance if self._bounces else self._contacts
        return np.asarray(counted.sum(axis=1) / self._frames[:, None])

    def duty_factor_of(self, foot: int) -> Floats:
        """Return the duty factor of one foot, (population,)."""
        return self.duty_factor[:, foot]

    @cached_property
    def touches(self) -> Floats:
        """Touches of each foot per stride, (population, feet); NaN without a stride.

        A stride that the foot spends on the ground or in the air, without touching down, counts as
        one touch, so 1 is a foot without chatter.
        """
        extra = touch_downs(self._contacts).sum(axis=1) - self.downs.sum(axis=1)
        strides = np.full(len(extra), np.nan)
        np.divide(self._frames, self.period, out=strides, where=self.period > 0)
        return np.asarray(1 + extra / strides[:, None])

    def phase_lag(self, pairs: Sequence[tuple[int, int]]) -> Floats:
        """Return the phase of touch-downs in the strides of other feet, cycles from 0 to 1.

        Args:
            pairs: pairs of feet; the second foot touches down in the strides of the first.

        Returns:
            The circular mean over all strides and pairs, (population,); NaN without a stride.
        """
        population, frames, _ = self.downs.shape
        east, north, count = np.zeros((3, population))
        for one, other in pairs:
            starts, ends = _last_event(self.downs[..., one]), _next_event(self.downs[..., one])
            within = self.downs[..., other] & (starts >= 0) & (ends < frames)
            individual, frame = np.nonzero(within & (self.period > 0)[:, None])
            start, end = starts[individual, frame], ends[individual, frame]
            angle = 2 * np.pi * (frame - start) / (end - start)
            east += np.bincount(individual, cos(angle), population)
            north += np.bincount(individual, sin(angle), population)
            count += np.bincount(individual, minlength=population)
        cycles = (arctan2(north, east) / (2 * np.pi)) % 1.0
        return np.where(count > 0, np.where(cycles < 1 - 1e-9, cycles, 0.0), np.nan)


def angles_frequency(joint_angles: NDArray[np.floating[Any]], frame_rate: float) -> Floats:
    """Return the stride frequency of joint angles, (population,) Hz; 0 if they are not periodic.

    It is the frequency at which joints cross their median angle, found like that of contacts
    (`estimate_period`). Joints with less than a tenth of the largest range are not counted.

    Args:
        joint_angles: joint angles, (population, frames, joints) rad.
        frame_rate: frames per second, Hz.
    """
    found = np.zeros(len(joint_angles))
    for index, angles in enumerate(joint_angles):
        span = np.ptp(angles, axis=0)
        moving = angles[:, span > MIN_MOTION * span.max()]
        if moving.size:
            beyond = moving > np.median(moving, axis=0)  # a range would depend on the start
            found[index] = Steps(beyond[None], frame_rate).frequency[0]
    return found


def stepping_measures(
    stance: NDArray[np.bool_],
    legs: Sequence[str],
    frame_rate: float,
    *,
    sides: Sequence[Sequence[str]] = (),
    upright: NDArray[np.intp] | None = None,
    commanded: Floats | None = None,
) -> dict[str, Measure]:
    """Return measures of the steps of legs.

    - `duty factor`: mean share of the time that a foot is in stance (Alexander 1984, "The gaits
      of bipedal and quadrupedal animals"). Each foot also has its own measure, such as
      'duty factor L1'.
    - `stride frequency`: strides per second; 0 if fewer than half of the feet step.
    - `phase lag`: phase at which a foot touches down in the stride of the foot in front of it on
      the same side, in cycles from 0 to 1 (Hildebrand 1965, "Symmetrical gaits of horses"). This is
      the circular mean over all strides and pairs; NaN without a stride. Only with `sides`.
    - `chatter`: touches per foot and stride beyond the first; NaN without a stride. Only with
      `upright`, for bodies in physics.

    `Steps` describes stances and strides, and the arguments that are not listed here.

    Args:
        stance: whether each foot is on the ground, (population, frames, feet), in the order of
            `legs`.
        legs: names of the legs.
        frame_rate: frames per second, Hz.
        sides: names of the legs on each side, front to back.
        upright: number of frames before each individual's fall; None for a kinematic body.
        commanded: stride frequency that the gait commands, Hz.
    """
    steps = Steps(stance, frame_rate, upright, commanded)
    pairs = [
        (legs.index(front), legs.index(rear)) for side in sides for front, rear in pairwise(side)
    ]
    duties = {
        f"{DUTY} {name}": Measure(
            partial(steps.duty_factor_of, leg),
            "",
            f"share of the time that the foot of {name} is in stance",
        )
        for leg, name in enumerate(legs)
    }
    found = {
        DUTY: Measure(
            lambda: steps.duty_factor.mean(axis=1),
            "",
            "share of the time that a foot is in stance, averaged over the feet",
        ),
        **duties,
        "stride frequency": Measure(
            lambda: steps.frequency, "Hz", "strides per second; 0 without a stride"
        ),
    }
    if pairs:
        found["phase lag"] = Measure(
            lambda: steps.phase_lag(pairs),
            "cycles",
            "mean phase of a foot's touch-downs in the stride of the next foot in front of it",
        )
    if upright is not None:
        found["chatter"] = Measure(
            lambda: steps.touches.mean(axis=1) - 1,
            "",
            "touches per foot and stride beyond the first; 0 for feet that do not bounce",
        )
    return found
