"""Measures of the steps of legs, for whole populations."""

from collections.abc import Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Measure
from gaitsim.legged.rhythm import (
    Floats,
    mean_stride,
    phase_lag,
    stride_lag,
    touch_downs,
    without_chatter,
)

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
