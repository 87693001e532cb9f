"""The report can be recomputed from its files alone, without the code that wrote them."""

import csv
import io
import math
from collections import Counter

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq

from gaitsim_studies.comparison import Sample, analyse, load_experiments
from gaitsim_studies.comparison_report import curves, report, results

REPEATS = 20
GENERATIONS = {"millipede": 650, "millipede-random": 240}


@pytest.fixture(scope="module")
def found():
    rng = np.random.default_rng(4)
    samples = {}
    for label, experiment in load_experiments([*GENERATIONS], {}).items():
        shape = (REPEATS, GENERATIONS[label])
        rises = rng.exponential(1 + rng.random((REPEATS, 1)), shape) * (rng.random(shape) < 0.05)
        best = np.round(np.cumsum(rises, axis=1) * (600 / GENERATIONS[label]), 3)
        best[3, :2] = -np.inf  # all individuals failed
        samples[label] = Sample(experiment, best)
    return analyse(samples, 7 + max(int(one.evaluations[-1]) for one in samples.values()))


@pytest.fixture(scope="module")
def tables(found) -> list[list[list[str]]]:
    """Return the rows of each table of the report."""
    parts = report(found, "x", []).split("\n## ")[1:]
    lines = [[line for line in part.splitlines() if line.startswith("|")][2:] for part in parts]
    return [[line.strip("| ").split(" | ") for line in rows] for rows in lines]


@pytest.fixture(scope="module")
def runs(found) -> dict[str, list[list[tuple[int, float]]]]:
    """Return the evaluations and scores of each repeat, by experiment."""
    held = {label: [[] for _ in range(REPEATS)] for label in GENERATIONS}
    for row in csv.DictReader(io.StringIO(results(found))):
        at = int(row["evaluations"]), float(row["best"])
        held[row["experiment"]][int(row["repeat"]) - 1].append(at)
    return held


def runtimes(each, target) -> np.ndarray:
    return np.array([next((at for at, best in run if best >= target), np.inf) for run in each])


def cell(values, form: str) -> list[str]:
    return form.format(*values).split(" | ")


def hall(values) -> list[float]:
    """Return the ends of Student's t interval after Hall's transformation, solved numerically."""
    n, mean, error = len(values), np.mean(values), stats.sem(values)
    g = np.mean(((values - mean) / np.std(values, ddof=1)) ** 3) / math.sqrt(n)
    t = stats.t.ppf(0.975, n - 1)
    return [
        mean
        - error * brentq(lambda x, q=q: x + g * x**2 / 3 + g**2 * x**3 / 27 + g / 6 - q, -1e3, 1e3)
        for q in (t, -t)
    ]


def rate(successes) -> list[float]:
    """Return the ends of the interval of Clopper and Pearson, from their definition."""
    below = stats.beta(successes, REPEATS - successes + 1).ppf(0.025) if successes else 0
    above = stats.beta(successes + 1, REPEATS - successes).ppf(0.975) if successes < REPEATS else 1
    return [below, above]


def a12(one, other) -> list[float]:
    """Return A12 and its interval: the wider of DeLong's on the logit scale, and Newcombe's."""
    wins = np.greater.outer(one, other) + np.equal.outer(one, other) / 2
    variance = sum(np.var(wins.mean(axis), ddof=1) / wins.shape[1 - axis] for axis in (0, 1))
    share, z = wins.mean(), stats.norm.ppf(0.975)
    reach = z * math.sqrt(variance) / share / (1 - share)
    middle = math.log(share / (1 - share))
    ends = [1 / (1 + math.exp(-middle - part)) for part in (-reach, reach)]

    def excess(a: float) -> float:
        factor = 1 + (REPEATS - 1) * ((1 - a) / (2 - a) + a / (1 + a))
        return (a - share) ** 2 - z**2 * a * (1 - a) * factor / REPEATS**2

    newcombe = brentq(excess, 0, share), brentq(excess, share, 1)
    return [share, min(ends[0], newcombe[0]), max(ends[1], newcombe[1])]


def test_the_scores_follow_from_the_files(found, tables, runs) -> None:
    finals = {label: np.array([run[-1][1] for run in each]) for label, each in runs.items()}
    for row, (label, final) in zip(tables[0], finals.items(), strict=True):
        low, high = np.sort(final)[[5, -6]]  # of 20; the ranks in tables of the sign test, 6 and 15
        values = [np.median(final), low, high, *np.quantile(final, [0.25, 0.75])]
        form = "{:.3f} | {:.3f} to {:.3f} | {:.3f} to {:.3f} | {:.3f} to {:.3f}"
        assert row == [label, *cell([*values, final.min(), final.max()], form)]
    p = stats.mannwhitneyu(*finals.values(), method="exact").pvalue
    pairs = [p, *(float(text.split()[0]) for row in tables[4] for text in row[2:4])]
    assert tables[1][0][1] == f"{p:.2g}"
    assert float(tables[1][0][2]) == pytest.approx(holm(pairs)[0], rel=0.1)
    assert tables[1][0][3:5] == cell(a12(*finals.values()), "{:.3f} | {:.3f} to {:.3f}")
    targets = [float(text) for text in dict.fromkeys(row[0] for row in tables[3])]
    pooled = np.sort(np.concatenate(list(finals.values())))
    step = 10 ** (math.floor(math.log10(np.ptp(pooled))) - 3)
    assert targets == pytest.approx(np.floor(pooled[[9, 19, 29]] / step) * step)


def test_the_areas_follow_from_the_files(found, tables, runs) -> None:
    firsts = [np.median([run[0][1] for run in each]) for each in runs.values()]
    targets = np.linspace(
        min(firsts), max(run[-1][1] for each in runs.values() for run in each), 51
    )
    assert targets == pytest.approx(found.targets)
    for row, (label, each) in zip(tables[2], runs.items(), strict=True):
        times = np.array([runtimes(each, target) for target in found.targets])
        area = np.maximum(0, 1 - times / found.evaluations).mean(axis=0)
        values = [area.mean(), *np.clip(hall(area), 0, 1), 100 * np.isfinite(times).mean()]
        assert row == [label, *cell(values, "{:.3f} | {:.3f} to {:.3f} | {:.0f} %")]
        for one in csv.DictReader(io.StringIO(curves(found))):
            if one["experiment"] == label:
                share = (times <= int(one["evaluations"])).mean()
                assert float(one["share"]) == pytest.approx(share)


def test_the_running_times_follow_from_the_files(tables, runs) -> None:
    for target, label, *row in tables[3]:
        times = runtimes(runs[label], float(target))
        won, budget = np.isfinite(times), runs[label][0][-1][0]
        spent = np.where(won, times, budget).sum()
        ends = rate(won.sum())
        text = f"{won.sum()} of {REPEATS} | {100 * ends[0]:.0f} to {100 * ends[1]:.0f} %"
        mean, (low, high) = times[won].mean(), hall(times[won])
        lost, most, least = (budget * (1 / one - 1) for one in (won.mean(), *ends))
        low, high = max(low, runs[label][0][0][0]), min(high, budget)
        below = mean + lost - math.hypot(mean - low, lost - least)
        above = mean + lost + math.hypot(high - mean, most - lost)
        text += f" | {spent / won.sum():,.0f} | {below:,.0f} to {above:,.0f}"
        assert row == text.split(" | ")


def rank_test(one, other) -> float:
    """Return twice the smaller tail of the rank sum, by enumerating all assignments of ranks."""
    ranks = (2 * stats.rankdata([*one, *other])).astype(int).tolist()
    ways = [Counter({0: 1}), *(Counter() for _ in one)]
    for rank in ranks:
        for taken in range(len(one), 0, -1):
            for total, number in ways[taken - 1].items():
                ways[taken][total + rank] += number
    seen = sum(ranks[: len(one)])
    below = sum(number for total, number in ways[-1].items() if total <= seen)
    above = sum(number for total, number in ways[-1].items() if total >= seen)
    return min(1, 2 * min(below, above) / math.comb(len(ranks), len(one)))


def holm(values) -> list[float]:
    ordered = sorted(values)
    steps = [(len(values) - rank) * p for rank, p in enumerate(ordered)]
    return [min(1, max(steps[: ordered.index(p) + 1])) for p in values]


def test_the_tests_at_the_targets_follow_from_the_files(tables, runs) -> None:
    times = [[runtimes(each, float(target)) for each in runs.values()] for target, *_ in tables[4]]
    won = [[int(np.isfinite(one).sum()) for one in pair] for pair in times]
    fisher = [stats.fisher_exact([pair, [REPEATS - k for k in pair]]).pvalue for pair in won]
    ranks = [rank_test(*pair) for pair in times]
    finals = [[run[-1][1] for run in each] for each in runs.values()]
    corrected = holm([rank_test(*finals), *fisher, *ranks])[1:]
    for column, values, after in ((2, fisher, corrected[:3]), (3, ranks, corrected[3:])):
        said = [f"{p:.2g} ({q:.2g})" for p, q in zip(values, after, strict=True)]
        assert [row[column] for row in tables[4]] == said
    for row, (one, other) in zip(tables[4], times, strict=True):
        assert row[4:6] == cell(a12(other, one), "{:.3f} | {:.3f} to {:.3f}")
