"""Measures of how legs step, for whole populations."""

from collections.abc import Sequence
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Measure

DUTY = "duty factor"


def stepping(stance: NDArray[np.bool_], legs: Sequence[str]) -> dict[str, Measure]:
    """Return the mean duty factor of all legs, and that of each, such as 'duty factor L1'.

    The duty factor is the share of the time that a foot is on the ground (Alexander 1984, "The
    gaits of bipedal and quadrupedal animals").

    Args:
        stance: which feet are on the ground, (population, frames, feet), in the order of `legs`.
        legs: their names.
    """
    steps = _Steps(stance)
    mean = Measure(steps.mean, "", "share of the time that a foot is on the ground, mean of all")
    return {DUTY: mean} | {
        f"{DUTY} {name}": Measure(
            partial(steps.of, leg),
            "",
            f"share of the time that the foot of {name} is on the ground",
        )
        for leg, name in enumerate(legs)
    }


class _Steps:
    """What the measures share, computed when the first of them is read."""

    def __init__(self, stance: NDArray[np.bool_]) -> None:
        self._stance = stance

    @cached_property
    def _shares(self) -> NDArray[np.float64]:
        return np.asarray(self._stance.mean(axis=1))

    def mean(self) -> NDArray[np.float64]:
        return np.asarray(self._shares.mean(axis=1))

    def of(self, leg: int) -> NDArray[np.float64]:
        return self._shares[:, leg]
