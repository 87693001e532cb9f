"""Runs ranked by their champions in the same unseen worlds."""

from pathlib import Path

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait.unseen import Outcome, UnseenResults
from gaitsim.individual import Individual
from gaitsim.study.in_worlds import common_ranges, rank_in_worlds, ranking

RANGES = {"friction": (0.3, 1.2)}
RNG = np.random.default_rng(4)


def unseen(results):
    outcomes = tuple(Outcome(float(one), 0.0, fell=False) for one in results)
    worlds = tuple({"friction": 0.5} for _ in results)
    nominal = Outcome(2.0, 0.0, fell=False)
    return UnseenResults("forward", "m", nominal, RANGES, {"friction": ""}, 0, worlds, outcomes)


def test_runs_are_ranked_by_the_worst_tenth_in_paired_worlds():
    """A constant difference in each world has no spread, however much the worlds differ."""
    results = RNG.normal(1.5, 0.3, 100)
    wide = np.r_[np.full(90, 9.0), np.full(10, 0.1)]  # far on average, but with ten bad worlds
    found = ranking(
        {"wide": unseen(wide), "low": unseen(results - 0.2), "high": unseen(results)}, RANGES
    )
    assert [one.label for one in found.runs] == ["high", "low", "wide"]
    pair = found.pairs[0]
    assert (pair.first, pair.second) == ("high", "low")
    assert (pair.difference, pair.low, pair.high) == pytest.approx((0.2, 0.2, 0.2))
    assert pair.differs
    high = found.runs[0]
    assert high.low < high.unseen.worst_tenth < high.high < np.median(results)


def test_the_widest_ranges_are_used_and_named():
    def champion(**ranges):
        return Individual(load_experiment("walker", {"worlds.ranges": ranges}), 0.0, {})

    one = champion(friction=[0.3, 0.8], slope=[-1, 1])
    other = champion(friction=[0.2, 0.6], slope=[-1, 1])
    ranges, [note] = common_ranges({"one": one, "other": other})
    assert ranges == {"friction": (0.2, 0.8), "slope": (-1, 1)}
    assert "friction" in note
    assert "slope" not in note
    assert common_ranges({"one": one, "same": one}) == (one.experiment.worlds.ranges, ())


@pytest.mark.parametrize(("runs", "named"), [(["a"], "two runs"), (["a", "./a"], "twice")])
def test_fewer_than_two_runs_are_rejected(runs, named):
    with pytest.raises(GaitsimError, match=named):
        rank_in_worlds([Path(one) for one in runs])
