"""Runtimes of repeats until they reach target scores: ECDFs and expected running times.

Source: Hansen, Auger, Ros, Mersmann, Tušar & Brockhoff (2021, "COCO: a platform for comparing
continuous optimizers in a black-box setting"). A runtime is a number of evaluations. A score
counts once its generation is finished, which is when the search receives it.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal

import numpy as np
from numpy.typing import NDArray

from gaitsim_studies.statistics import (
    CONFIDENCE,
    LEAST,
    NO_INTERVAL,
    Interval,
    Means,
    mean_interval,
    rate_interval,
)

TARGETS = 51
"""Number of targets of the ECDF unless the user gives targets."""

GIVEN = "given by the user"
SPACED = (
    "equally spaced from the lowest median of the first generations to the highest score of all "
    "repeats"
)
QUARTILES = (
    "the quartiles of the finite best scores of all repeats of all experiments together, rounded "
    "down"
)
DIGITS = 4  # targets are rounded down to this many digits of the range of scores

Scores = NDArray[np.float64]
Counts = NDArray[np.int64]


def target_text(target: float) -> str:
    """Return a target as text, with enough digits to reproduce the number exactly."""
    return repr(float(target)).removesuffix(".0").replace("-", "−")


def spaced_targets(bests: Iterable[Scores]) -> Scores:
    """Return targets from the lowest median of the first scores to the highest final score.

    Args:
        bests: best score so far of each experiment, (repeats, generations); some are finite.

    Returns:
        At most `TARGETS` equally spaced scores, ascending.
    """
    every = [best for best in bests if np.isfinite(best).any()]
    starts = np.array([np.median(best[:, 0]) for best in every])
    if not np.isfinite(starts).all():  # in most repeats the whole first generation failed
        starts = np.array([best[np.isfinite(best)].min() for best in every])
    low, high = starts.min(), max(best[:, -1].max() for best in every)
    part = np.linspace(0, 1, TARGETS)
    return np.unique((1 - part) * low + part * high)  # high − low could overflow


@dataclass(frozen=True, eq=False)
class Ecdf:
    """The empirical distribution of runtimes over all pairs of a repeat and a target.

    Attributes:
        share: share of the pairs whose target is reached, (generations,).
        area: mean of the share over all evaluations of the budget; always below 1, which would
            mean all targets reached without an evaluation.
        low, high: confidence interval of the area; NaN if there is none.
    """

    share: Scores
    area: float
    low: float
    high: float


def ecdf(best: Scores, evaluations: Counts, budget: int, targets: Scores) -> Ecdf:
    """Return the ECDF of the runtimes of repeats.

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        budget: number of evaluations for the area, at least the last of `evaluations`.
        targets: scores to reach, ascending.
    """
    # A target stays reached even if new worlds are drawn and the best score is reset.
    highest = np.maximum.accumulate(best, axis=1)
    shares = np.searchsorted(targets, highest, side="right") / len(targets)
    # No target is reached before the first generation; the last share holds up to the budget.
    areas = shares @ np.diff(evaluations, append=budget) / budget
    low, high = np.clip(mean_interval(areas), 0, 1).tolist()
    return Ecdf(shares.mean(axis=0), float(areas.mean()), low, high)


@dataclass(frozen=True)
class TargetSummary:
    """A summary of how often and how soon repeats reach a target score.

    Attributes:
        target: score to reach.
        successes: number of repeats that reached the target.
        repeats: number of repeats.
        ert: expected running time: evaluations of all repeats until success or their end, divided
            by the number of successes; infinite without a success.
        low, high: confidence interval of the ERT; NaN if there is none. Without a success, the ERT
            and the upper end are infinite.
        rate_low, rate_high: confidence interval of the success rate.
    """

    target: float
    successes: int
    repeats: int
    ert: float
    low: float
    high: float
    rate_low: float
    rate_high: float

    @property
    def rate(self) -> float:
        """Share of repeats that reached the target."""
        return self.successes / self.repeats


def runtimes(best: Scores, evaluations: Counts, target: float) -> Scores:
    """Return the evaluations until each repeat reached a target, (repeats,); ∞ if it did not.

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        target: score to reach.
    """
    reached = best >= target
    return np.where(reached.any(axis=1), evaluations[reached.argmax(axis=1)], np.inf)


def summarise_target(best: Scores, evaluations: Counts, target: float) -> TargetSummary:
    """Return how often and how soon repeats reach a target.

    Args:
        best: best score so far, (repeats, generations).
        evaluations: number of evaluations of one repeat so far, (generations,).
        target: score to reach.
    """
    times = runtimes(best, evaluations, target)
    reached = times[np.isfinite(times)]
    spent = reached.sum() + (len(best) - len(reached)) * evaluations[-1]
    rate = rate_interval(len(reached), len(best))
    return TargetSummary(
        target,
        len(reached),
        len(best),
        float(spent / len(reached)) if len(reached) else math.inf,
        *_ert_interval(reached, len(best), int(evaluations[0]), int(evaluations[-1]), rate),
        *rate,
    )


def _ert_interval(reached: Scores, repeats: int, first: int, last: int, rate: Interval) -> Interval:
    """Return the confidence interval of an expected running time.

    The ERT is a sum: the mean time of a success, and the time that failures cost per success,
    (1 − p) / p times the budget for a success rate p. Each part has an interval; Zou & Donner
    (2008, "Construction of confidence limits about effect measures: a general approach") combine
    them. Resampling repeats would give no failures if none was observed, and thus too short
    intervals: with 30 repeats and a success rate of 0.97, as few as 73 % of them contain the ERT.

    Args:
        reached: times of the successes, evaluations, (successes,).
        repeats: number of repeats.
        first: evaluations of the first generation.
        last: evaluations of a repeat without success.
        rate: confidence interval of the success rate.
    """
    if repeats < LEAST:
        return NO_INTERVAL
    least, most = (last * _failures(one) for one in reversed(rate))
    if not len(reached):
        return first + least, math.inf
    mean, lost = float(reached.mean()), last * _failures(len(reached) / repeats)
    low, high = _time_interval(reached, first, last)
    return (
        mean + lost - math.hypot(mean - low, lost - least),
        mean + lost + math.hypot(high - mean, most - lost),
    )


def _failures(rate: float) -> float:
    """Return the expected number of failures for each success."""
    return (1 - rate) / rate if rate else math.inf


def _time_interval(reached: Scores, first: int, last: int) -> Interval:
    """Return the confidence interval of the mean time of successes, from one success on."""
    if len(reached) == 1:
        return float(first), float(last)
    if np.ptp(reached) == 0:
        return float(reached[0]), float(reached[0])
    low, high = Means.of(reached[:, None]).interval(CONFIDENCE)
    return max(float(low[0]), first), min(float(high[0]), last)


def chosen_targets(given: Sequence[float], finals: Iterable[Scores]) -> list[float]:
    """Return the targets of running times: the given targets, or quartiles of final scores.

    The quartiles of the pooled scores favour no experiment: they do not depend on which experiment
    a repeat belongs to, so rank and permutation tests remain valid. The median of one experiment,
    by contrast, would be a target that half of its own repeats reach by construction.

    A quartile is the score of a repeat, rounded down to `DIGITS` digits of the range of scores, so
    that the printed number gives the same running times.

    Args:
        given: targets of the user; () for none.
        finals: best score of each repeat, (repeats,), for each experiment; some are finite.
    """
    if given:
        return sorted(set(given))
    every = np.concatenate(list(finals))
    every = every[np.isfinite(every)]
    quartiles = np.quantile(every, [0.25, 0.5, 0.75], method="inverted_cdf")
    span = float(every.max()) - float(every.min())
    return sorted({_rounded_down(one, span) for one in quartiles.tolist()})


def _rounded_down(score: float, span: float) -> float:
    if span == 0 or not math.isfinite(span):
        return score
    step = Decimal(1).scaleb(math.floor(math.log10(span)) + 1 - DIGITS)
    return float(Decimal(repr(score)).quantize(step, ROUND_FLOOR))
