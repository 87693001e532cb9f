"""How soon repeats reach target scores: the ECDF of runtimes, and expected running times.

After Hansen, Auger, Ros, Mersmann, Tušar & Brockhoff (2021, "COCO: a platform for comparing
continuous optimizers in a black-box setting"). A runtime is a number of evaluations. A score
counts when its generation is finished, as a search sees none of it before.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal

import numpy as np
from numpy.typing import NDArray

from gaitsim.study.statistics import interval

TARGETS = 51
"""Number of targets of the ECDF that are chosen where none are given."""

GIVEN = "given by the user"
SPACED = (
    "equally spaced, from the lowest median of the first generations to the highest score of all "
    "repeats"
)
QUARTILES = (
    "the quartiles of the best scores of all repeats of all experiments together, rounded down"
)
DIGITS = 4  # of the range of scores, to which targets are rounded

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
    # A target stays reached, also where worlds are redrawn and the best score begins anew.
    highest = np.maximum.accumulate(best, axis=1)
    shares = np.searchsorted(targets, highest, side="right") / len(targets)
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


def runtimes(best: Scores, evaluations: Counts, target: float) -> Scores:
    """Return the evaluations of each repeat until it reached a target, ∞ where never, (repeats,).

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        target: the score to reach.
    """
    reached = best >= target
    return np.where(reached.any(axis=1), evaluations[reached.argmax(axis=1)], np.inf)


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
    times = runtimes(best, evaluations, target)
    success = np.isfinite(times)
    spent = np.where(success, times, evaluations[-1])
    successes = int(success.sum())
    # Successes per evaluation, the inverse of the ERT, stay finite in every resample.
    low, high = interval((success.astype(float), spent), _rate, rng)
    return TargetSummary(
        target, successes, len(best), _over(spent.sum(), successes), _over(1, high), _over(1, low)
    )


def _rate(success: Scores, spent: Scores, axis: int = -1) -> Scores:
    found: Scores = success.sum(axis=axis) / spent.sum(axis=axis)
    return found


def _over(value: float, divisor: float) -> float:
    return float(value / divisor) if divisor else math.inf


def chosen_targets(given: Sequence[float], finals: Iterable[Scores]) -> list[float]:
    """Return the targets of running times: those given, or the quartiles of all final scores.

    The quartiles of the pooled scores favour no experiment: they stay if repeats change places
    between experiments, so tests by rank or permutation remain valid. The median of one
    experiment would be a target that this one reaches in half of its repeats by construction.

    A quartile is the score of a repeat, rounded down to `DIGITS` digits of the range of scores: as
    a report prints it, it gives the same running times.

    Args:
        given: the targets of the user; () for none.
        finals: best score of each repeat of each experiment, (repeats,).
    """
    if given:
        return sorted(set(given))
    every = np.concatenate(list(finals))
    quartiles = np.quantile(every, [0.25, 0.5, 0.75], method="inverted_cdf")
    span = float(every.max()) - float(every.min())
    return sorted({_rounded_down(one, span) for one in quartiles.tolist()})


def _rounded_down(score: float, span: float) -> float:
    if span == 0 or not math.isfinite(span):
        return score
    step = Decimal(1).scaleb(math.floor(math.log10(span)) + 1 - DIGITS)
    return float(Decimal(repr(score)).quantize(step, ROUND_FLOOR))
