"""The conditions that hurt, compared with closed forms and SciPy."""

import numpy as np
import pytest
from scipy.stats import f_oneway, pearsonr

from gaitsim.gait.sensitivity import effects

UNIT = (-1.0, 1.0)


def drawn(worlds, *names, seed=0, span=UNIT):
    """A Latin hypercube, by name."""
    rng = np.random.default_rng(seed)
    low, high = span
    return {
        name: low + (high - low) * (rng.permutation(worlds) + rng.random(worlds)) / worlds
        for name in names
    }


def found(conditions, results, span=UNIT):
    return effects(conditions, dict.fromkeys(conditions, span), results)


def test_straight_responses_share_the_variance_as_their_squares():
    """The first-order index is a² / Σ a²; the means of thirds keep 8/9 of a straight response."""
    x = drawn(3000, "one", "two", "none")
    strong, weak = found(x, 3 * x["one"] - x["two"])
    assert (strong.condition, weak.condition) == ("one", "two")
    assert strong.share == pytest.approx(8 / 9 * 0.9, abs=0.01)
    assert weak.share == pytest.approx(8 / 9 * 0.1, abs=0.01)
    assert strong.hurting == ((-1.0, pytest.approx(-1 / 3)),)
    assert weak.hurting == ((pytest.approx(1 / 3), 1.0),)
    assert strong.loss == pytest.approx(3.0, abs=0.07)  # from −2 in the lowest third to 1


def test_a_condition_that_hurts_on_both_sides_is_found():
    """The thirds of −x² have the means −13/27, −1/27, −13/27; its variance is 4/45."""
    x = drawn(3000, "slope", "friction")
    results = -(x["slope"] ** 2)
    [effect] = found(x, results)
    assert abs(pearsonr(x["slope"], results).statistic) < 0.02
    assert effect.hurting == ((-1.0, pytest.approx(-1 / 3)), (pytest.approx(1 / 3), 1.0))
    assert effect.share == pytest.approx((12 / 27) ** 2 * 2 / 9 / (4 / 45), abs=0.01)
    assert effect.loss == pytest.approx(12 / 27, abs=0.01)
    assert effect.within(x["slope"]).sum() == 2000


def test_the_share_is_that_of_an_analysis_of_variance():
    x = drawn(100, "one", "two", seed=5)
    results = x["one"] + 0.3 * np.random.default_rng(6).standard_normal(100)
    effect = found(x, results)[0]
    groups = [results[np.searchsorted([-1 / 3, 1 / 3], x["one"]) == part] for part in range(3)]
    f = f_oneway(*groups).statistic
    assert effect.share == pytest.approx(1 - 99 / (97 + 2 * f))


def test_chance_is_seldom_taken_for_an_effect():
    """One of twenty at most on average, whatever the number of conditions."""
    names = tuple("abcdefghijkl")
    wrong = sum(
        bool(found(drawn(60, *names, seed=seed), np.random.default_rng(seed).random(60)))
        for seed in range(60)
    )
    assert wrong <= 6
