"""Rank runs by the results of their champions in the same unseen worlds."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import Ranges, conditions_of, ranges_of
from gaitsim.gait.unseen import UnseenResults, check_request, evaluate_unseen, worst_tenth
from gaitsim.individual import Individual
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_studies.statistics import CONFIDENCE, NO_INTERVAL, Interval

LEAST_WORLDS = 100
"""Least number of worlds for an interval of a worst tenth; with 50, it covers as little as 82 %."""

RESAMPLES = 9999
MOST_RESAMPLED = 2**23  # values at a time, 64 MB

Evaluate = Callable[[str, Individual, Ranges], UnseenResults]


@dataclass(frozen=True)
class Ranked:
    """A run in a ranking.

    Attributes:
        label: name of the run in the ranking.
        unseen: results of its champion.
        low, high: confidence interval of the mean of the worst tenth, from a bootstrap of worlds;
            NaN if there is none.
    """

    label: str
    unseen: UnseenResults
    low: float
    high: float


@dataclass(frozen=True)
class WorstTenths:
    """The difference between two runs in the same worlds.

    Attributes:
        first, second: labels; the first ranks higher.
        difference: difference of the means of the worst tenths.
        low, high: bootstrap confidence interval, with the same resampled worlds for both runs; NaN
            if there is none.
    """

    first: str
    second: str
    difference: float
    low: float
    high: float

    @property
    def differs(self) -> bool | None:
        """Whether the interval excludes 0; None if there is no interval."""
        return None if math.isnan(self.low) else self.low > 0 or self.high < 0


@dataclass(frozen=True)
class Ranking:
    """Runs by the mean of the worst tenth of their champions' results, the highest first.

    Attributes:
        runs: ranked runs.
        pairs: differences of every pair of runs.
        ranges: ranges of the conditions, the same for all runs.
        notes: remarks on the ranges; () for none.
    """

    runs: tuple[Ranked, ...]
    pairs: tuple[WorstTenths, ...]
    ranges: Ranges
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the ranking as values for JSON."""
        return {
            "ranges": {name: list(ends) for name, ends in self.ranges.items()},
            "notes": list(self.notes),
            "runs": [
                {
                    "run": one.label,
                    **one.unseen.statistics(),
                    "worst_tenth_low": one.low,
                    "worst_tenth_high": one.high,
                }
                for one in self.runs
            ],
            "pairs": [{**vars(pair), "differs": pair.differs} for pair in self.pairs],
        }


def rank_in_worlds(
    runs: Sequence[Path | str],
    number: int = 100,
    *,
    seed: int = 0,
    workers: int | None = None,
    evaluate: Evaluate | None = None,
) -> Ranking:
    """Evaluate the champions of runs in the same unseen worlds, and rank them by the worst tenth.

    If the range of a condition differs between runs, the widest range is used, from the lowest end
    to the highest.

    Args:
        runs: folders of two or more runs of the same body.
        number: number of worlds.
        seed: seed of the worlds.
        workers: number of workers; None for the body's default.
        evaluate: function that evaluates the champion of a label in given ranges; None for
            `evaluate_unseen`.
    """
    check_request(number, seed)
    if len(runs) < 2:
        raise GaitsimError("a comparison needs two runs", allowed="two runs or more")
    paths = [Path(one) for one in runs]
    if len({path.resolve() for path in paths}) < len(paths):
        raise GaitsimError("a run is given twice", allowed="different runs")
    names = [path.name for path in paths]
    labels = [
        name if names.count(name) == 1 else str(path)
        for name, path in zip(names, paths, strict=True)
    ]
    champions = {
        label: RunSnapshot(path).individual() for label, path in zip(labels, paths, strict=True)
    }
    _check_bodies(champions)
    ranges, notes = common_ranges(champions)
    evaluate = evaluate or (
        lambda _, one, ranges: evaluate_unseen(
            one, number, seed=seed, ranges=ranges, workers=workers
        )
    )
    found = {label: evaluate(label, one, ranges) for label, one in champions.items()}
    if len({(one.measure, one.unit) for one in found.values()}) > 1:
        raise GaitsimError(
            "the runs cannot be compared: their scores have different units, and not all of them "
            "measure a distance",
            allowed="runs with the same fitness",
        )
    return ranking(found, ranges, notes)


def ranking(
    unseen: Mapping[str, UnseenResults], ranges: Ranges, notes: Sequence[str] = ()
) -> Ranking:
    """Rank runs, by label, by their results in the same worlds."""
    order = sorted(unseen, key=lambda label: -unseen[label].worst_tenth)
    results = {label: unseen[label].results for label in order}
    ranked = tuple(
        Ranked(label, unseen[label], *_interval((results[label],), _worst)) for label in order
    )
    pairs = tuple(
        WorstTenths(
            one,
            other,
            unseen[one].worst_tenth - unseen[other].worst_tenth,
            *_interval((results[one], results[other]), _difference),
        )
        for one, other in itertools.combinations(order, 2)
    )
    return Ranking(ranked, pairs, dict(ranges), tuple(notes))


def common_ranges(champions: Mapping[str, Individual]) -> tuple[Ranges, tuple[str, ...]]:
    """Return the widest range of each condition that varies in a run, and remarks on them."""
    own = {label: ranges_of(one.experiment) for label, one in champions.items()}
    names = list(dict.fromkeys(name for ranges in own.values() for name in ranges))
    widest = {
        name: (
            min(ranges[name][0] for ranges in own.values() if name in ranges),
            max(ranges[name][1] for ranges in own.values() if name in ranges),
        )
        for name in names
    }
    differing = [
        name for name in names if any(ranges.get(name) != widest[name] for ranges in own.values())
    ]
    if not differing:
        return widest, ()
    return widest, (
        f"The runs vary {', '.join(differing)} in different ranges. The widest ranges are used.",
    )


def _check_bodies(champions: Mapping[str, Individual]) -> None:
    first_label, first = next(iter(champions.items()))
    name = first.experiment.entries["organism"].name
    for label, one in champions.items():
        conditions_of(one.experiment)
        other = one.experiment.entries["organism"].name
        if other != name:
            raise GaitsimError(
                f"{first_label} has the body {name!r}, but {label} has the body {other!r}",
                allowed="runs of the same body",
            )


def _worst(results: NDArray[np.float64], axis: int = -1) -> NDArray[np.float64]:
    return worst_tenth(np.moveaxis(results, axis, -1))


def _difference(
    one: NDArray[np.float64], other: NDArray[np.float64], axis: int = -1
) -> NDArray[np.float64]:
    return np.asarray(_worst(one, axis) - _worst(other, axis))


def _interval(results: tuple[NDArray[np.float64], ...], statistic: Callable[..., Any]) -> Interval:
    """Return the 95 % bootstrap interval of a statistic of worst tenths.

    A worst tenth is the mean of few values, k, so the percentiles are wider than usual, as for
    Student's t of k values (Hesterberg 2015, "What teachers should know about the bootstrap",
    section 5.3). There is no interval if a motion failed, or below `LEAST_WORLDS` worlds.

    Args:
        results: results of each run in the same worlds, (worlds,) each.
        statistic: function of the results along an `axis`.
    """
    from scipy.special import ndtr, stdtrit
    from scipy.stats import bootstrap

    worlds = len(results[0])
    if worlds < LEAST_WORLDS or not all(np.isfinite(one).all() for one in results):
        return NO_INTERVAL
    counted = -(-worlds // 10)
    quantile = math.sqrt(counted / (counted - 1)) * stdtrit(counted - 1, (1 + CONFIDENCE) / 2)
    found = bootstrap(
        results,
        statistic,
        n_resamples=RESAMPLES,
        batch=max(1, MOST_RESAMPLED // worlds),
        vectorized=True,
        paired=True,
        confidence_level=float(2 * ndtr(quantile) - 1),
        method="percentile",
        rng=np.random.default_rng(0),
    ).confidence_interval
    return float(found.low), float(found.high)
