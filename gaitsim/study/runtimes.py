"""How soon repeats reach target scores: the ECDF of runtimes, and expected running times.

After Hansen, Auger, Ros, Mersmann, Tušar & Brockhoff (2021, "COCO: a platform for comparing
continuous optimizers in a black-box setting"). A runtime is a number of evaluations. A score
counts when its generation is finished, as a search sees none of it before.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.study.statistics import interval

TARGETS = 51
"""Number of targets that are chosen where none are given."""

Scores = NDArray[np.float64]
Counts = NDArray[np.int64]


def spaced_targets(bests: Iterable[Scores]) -> Scores:
    """Return targets from the lowest median of the first scores to the highest score of all.

    Args:
        bests: best score so far of each experiment, (repeats, generations).

    Returns:
        At most `TARGETS` scores at equal distances, ascending.
    """
    every = list(bests)
    starts = np.array([np.median(best[:, 0]) for best in every])
    if not np.isfinite(starts).all():  # most first generations failed
        starts = np.array([best[np.isfinite(best)].min() for best in every])
    low, high = starts.min(), max(best[:, -1].max() for best in every)
    part = np.linspace(0, 1, TARGETS)
    return np.unique((1 - part) * low + part * high)  # their difference might overflow


@dataclass(frozen=True, eq=False)
class Ecdf:
    """The empirical distribution of runtimes over all pairs of a repeat and a target.

    Attributes:
        share: of the pairs, those whose target is reached, (generations,).
        area: the mean of the share over all evaluations of the budget; 1 is out of reach, as
            would be all targets without an evaluation.
        low, high: 95 % bootstrap interval of the area, over repeats.
    """

    share: Scores
    area: float
    low: float
    high: float


def ecdf(
    best: Scores, evaluations: Counts, budget: int, targets: Scores, rng: np.random.Generator
) -> Ecdf:
    """Return the ECDF of the runtimes of repeats.

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        budget: the evaluations up to which the area is taken, at least the last of these.
        targets: scores to reach, ascending.
        rng: draws the resamples.
    """
    shares = np.searchsorted(targets, best, side="right") / len(targets)
    # Nothing is reached before the first generation; the last one's share lasts to the budget.
    areas = shares @ np.diff(evaluations, append=budget) / budget
    low, high = interval((areas,), np.mean, rng)
    return Ecdf(shares.mean(axis=0), float(areas.mean()), low, high)


@dataclass(frozen=True)
class TargetSummary:
    """How often and how soon a target score is reached.

    Attributes:
        target: the score.
        successes: number of repeats that reached it.
        repeats: number of repeats.
        ert: expected running time: evaluations of all repeats until success or their end, over
            successes; infinite without a success.
        low, high: 95 % bootstrap interval of the ERT, over repeats; infinite where resamples
            have no success.
    """

    target: float
    successes: int
    repeats: int
    ert: float
    low: float
    high: float

    @property
    def rate(self) -> float:
        """The share of repeats that reached the target."""
        return self.successes / self.repeats


def summarise_target(
    best: Scores, evaluations: Counts, target: float, rng: np.random.Generator
) -> TargetSummary:
    """Return how often and how soon repeats reach a target.

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        target: the score to reach.
        rng: draws the resamples.
    """
    reached = best >= target
    success = reached.any(axis=1)
    spent = evaluations[np.where(success, reached.argmax(axis=1), best.shape[1] - 1)]
    successes = int(success.sum())
    # Successes per evaluation, the inverse of the ERT, stay finite in every resample.
    low, high = interval((success.astype(float), spent.astype(float)), _rate, rng)
    return TargetSummary(
        target, successes, len(best), _over(spent.sum(), successes), _over(1, high), _over(1, low)
    )


def _rate(success: Scores, spent: Scores, axis: int = -1) -> Scores:
    found: Scores = success.sum(axis=axis) / spent.sum(axis=axis)
    return found


def _over(value: float, divisor: float) -> float:
    return float(value / divisor) if divisor else math.inf


def chosen_targets(given: Sequence[float], medians: Iterable[float]) -> list[float]:
    """Return the targets of expected running times: those given, or the median of each."""
    return sorted(set(given) or set(medians))
