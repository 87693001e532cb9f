"""Coverage of the 95 % intervals that gaitsim prints, simulated with known true values.

The tables show the share of simulated sets of repeats whose interval contains the true value.
For the smallest sets, gaitsim prints no intervals; here they are computed, to show why.
"""

import argparse
from collections.abc import Callable, Mapping
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from gaitsim_studies import runtimes, statistics
from gaitsim_studies.results import markdown

Values = NDArray[np.float64]
Draw = Callable[[int], Values]
REPEATS = (2, 3, 5, 6, 10, 20, 30)
LARGE = 2_000_000  # values for true values without a closed form

rng = np.random.default_rng(0)

# Scores of repeats: a search with two modes, as CMA-ES with the spider; scores close below an
# optimum; and repeats that fail.
SCORES: dict[str, Draw] = {
    "normal": lambda n: rng.normal(2.5, 0.1, n),
    "two modes": lambda n: _mixed(0.4, rng.normal(2.2, 0.05, n), rng.normal(2.6, 0.03, n)),
    "skewed": lambda n: 2.6 - 0.1 * np.exp(0.8 * rng.standard_normal(n)),
    "10 % in a low mode": lambda n: _mixed(0.1, rng.normal(1.6, 0.1, n), rng.normal(2.6, 0.03, n)),
    "20 % failed": lambda n: _mixed(0.2, np.full(n, -np.inf), rng.normal(2.5, 0.1, n)),
}
# Pairs of samples, for effect sizes.
PAIRS: dict[str, tuple[Draw, Draw]] = {
    "equal": (SCORES["normal"], SCORES["normal"]),
    "shifted by one s.d.": (lambda n: rng.normal(2.6, 0.1, n), SCORES["normal"]),
    "shifted by three s.d.": (lambda n: rng.normal(2.8, 0.1, n), SCORES["normal"]),
    "s.d. 1 : 5": (lambda n: rng.normal(2.8, 0.1, n), lambda n: rng.normal(2.5, 0.5, n)),
    "two modes, against scores between": (SCORES["two modes"], lambda n: rng.normal(2.4, 0.01, n)),
    "20 % failed, against normal": (SCORES["20 % failed"], SCORES["normal"]),
    "times, 60 and 30 % never": (lambda n: -_times(n, 0.4), lambda n: -_times(n, 0.7)),
    "times, 90 % and all never": (lambda n: -_times(n, 0.1), lambda n: -_times(n, 0.0)),
}
RATES = 0.03, 0.1, 0.5, 0.9, 0.97
BUDGET, FIRST = 10_000, 200  # evaluations of a repeat, and of its first generation


def _mixed(share: float, one: Values, other: Values) -> Values:
    return np.where(rng.random(len(one)) < share, one, other)


def _times(n: int, rate: float, late: bool = False) -> Values:
    """Return evaluations until a target is reached, most of them early or late; ∞ if never."""
    drawn = rng.exponential(2000, n)
    times = np.clip(BUDGET - drawn if late else FIRST + drawn, FIRST, BUDGET)
    whole = FIRST * np.ceil(times / FIRST)
    return np.where(rng.random(n) < rate, whole, np.inf)


def _coverage(sets: int, truth: float, interval: Callable[[], tuple[float, float]]) -> str:
    """Return the share of intervals that contain a value, as text."""
    found = np.array([interval() for _ in range(sets)])
    near = 1e-9 * abs(truth)
    held = (found[:, 0] <= truth + near) & (truth - near <= found[:, 1])
    known = ~np.isnan(found[:, 0])
    return f"{100 * held[known].mean():.0f}" if known.any() else "–"


def medians(sets: int) -> Mapping[str, list[str]]:
    """Cover medians."""
    return {
        name: [
            _coverage(sets, truth, lambda n=n, draw=draw: statistics.median_interval(draw(n)))
            for n in REPEATS
        ]
        for name, draw in SCORES.items()
        for truth in [float(np.median(draw(LARGE)))]
    }


def areas(sets: int) -> Mapping[str, list[str]]:
    """Cover means: areas under the ECDF of a score, or of the time to one target."""
    draws = {name: draw for name, draw in SCORES.items() if name != "20 % failed"}
    for rate in (0.7, 0.97):
        draws[f"one target, {100 * rate:.0f} % reach it"] = lambda n, rate=rate: np.maximum(
            0, 1 - _times(n, rate) / BUDGET
        )
    return {
        name: [
            _coverage(sets, truth, lambda n=n, draw=draw: statistics.mean_interval(draw(n)))
            for n in REPEATS
        ]
        for name, draw in draws.items()
        for truth in [float(draw(LARGE).mean())]
    }


def rates(sets: int) -> Mapping[str, list[str]]:
    """Cover success rates."""
    return {
        f"{rate:.2f}": [
            _coverage(
                sets,
                rate,
                lambda n=n, rate=rate: statistics.rate_interval(int(rng.binomial(n, rate)), n),
            )
            for n in REPEATS
        ]
        for rate in RATES
    }


def running_times(sets: int) -> Mapping[str, list[str]]:
    """Cover expected running times."""
    evaluations = np.arange(FIRST, BUDGET + 1, FIRST)

    def interval(n: int, rate: float, late: bool) -> tuple[float, float]:
        best = (evaluations >= _times(n, rate, late)[:, None]).astype(float)
        found = runtimes.summarise_target(best, evaluations, 1.0)
        return found.low, found.high

    def truth(rate: float, late: bool) -> float:
        times = _times(LARGE, rate, late)
        return float(times[np.isfinite(times)].mean() + BUDGET * (1 / rate - 1))

    return {
        f"rate {rate:.2f}, {'late' if late else 'early'}": [
            _coverage(sets, value, lambda n=n, rate=rate, late=late: interval(n, rate, late))
            for n in REPEATS
        ]
        for rate in (*RATES, 1.0)
        for late in (False, True)
        for value in [truth(rate, late)]
    }


def effects(sets: int) -> Mapping[str, list[str]]:
    """Cover the effect size A12."""

    def truth(one: Values, other: Values) -> float:
        ranks = stats.rankdata(np.concatenate([one, other]))
        return float((ranks[: len(one)].mean() - (len(one) + 1) / 2) / len(other))

    return {
        f"{name} (A12 = {value:.2f})": [
            _coverage(
                sets,
                value,
                lambda n=n, one=one, other=other: statistics.effect_interval(one(n), other(n)),
            )
            for n in REPEATS
        ]
        for name, (one, other) in PAIRS.items()
        for value in [truth(one(LARGE // 4), other(LARGE // 4))]
    }


def confirmations(sets: int) -> Mapping[str, list[str]]:
    """Cover means in studies at the level of a single experiment's first test, 97.5 %."""
    found = {}
    for name, draw in SCORES.items():
        if name == "20 % failed":
            continue
        truth = float(draw(LARGE).mean())

        def interval(n: int, draw: Draw = draw) -> tuple[float, float]:
            low, high = statistics.Means.of(draw(n)[:, None]).interval(0.975)
            return float(low[0]), float(high[0])

        found[name] = [_coverage(sets, truth, lambda n=n, f=interval: f(n)) for n in (100, 300)]
    return found


def main() -> None:
    """Print one table for each kind of interval."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=1000, help="simulated sets per figure")
    sets = parser.parse_args().sets
    kinds = {
        "median": medians,
        "area under the ECDF": areas,
        "success rate": rates,
        "expected running time": running_times,
        "A12": effects,
    }
    print(f"Coverage of 95 % intervals, %, in {sets:,} simulated sets of repeats\n")
    with (
        patch.object(statistics, "LEAST", 2),
        patch.object(statistics, "LEAST_FOR_MEANS", 2),
        patch.object(runtimes, "LEAST", 2),
    ):
        for title, cover in kinds.items():
            _print(title, "repeats", REPEATS, cover(sets))
    _print("mean of a study, nominally 97.5 %", "repeats", (100, 300), confirmations(sets))


def _print(title: str, unit: str, counts: tuple[int, ...], rows: Mapping[str, list[str]]) -> None:
    head = [title, *(f"{one} {unit}" for one in counts)]
    print("\n".join(markdown(head, ([name, *cells] for name, cells in rows.items()))), end="\n\n")


if __name__ == "__main__":
    main()
