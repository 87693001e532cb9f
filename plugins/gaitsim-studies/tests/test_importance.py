"""Shares of the variance of scores that the options of a study explain."""

import itertools
import json
import math

import numpy as np
import pytest

import gaitsim as gs
from gaitsim_studies.file import STUDY
from gaitsim_studies.importance import REST, SEED, decompose
from gaitsim_studies.importance_plot import importance_figure
from gaitsim_studies.results import list_folders, sections

STUDY_TEXT = """
name = "small"
experiments = ["millipede-mutation"]
set = { "evolution.generations" = 4 }
repeats = 6
record_every = 4
[axes]
"evolution.population" = [5, 9]
"organism.pairs" = [2, 3]
"mutation.count" = [1]
"""
LEVELS = {"a": [0, 1, 2], "b": [0, 1, 2, 3], "c": [0, 1]}


def shares_of(found):
    return {one.options: one.share for one in found.shares}


def noisy_scores():
    a, b, c = np.meshgrid(*LEVELS.values(), indexing="ij")
    true = a + 0.5 * b + 0.3 * a * b + 0.1 * a * b * c
    return true[..., None] + np.random.default_rng(3).normal(0, 0.5, (*true.shape, 5))


def test_shares_of_one_repeat_are_those_of_a_closed_form():
    # f = 3 a + b + 2 a b with a, b = ±1: the variances of the effects are 9, 1 and 4.
    a, b = np.meshgrid([-1.0, 1.0], [-1.0, 1.0], indexing="ij")
    found = decompose({"a": [-1, 1], "b": [-1, 1]}, (3 * a + b + 2 * a * b)[..., None])
    expected = {("a",): 9 / 14, ("a", "b"): 4 / 14, ("b",): 1 / 14}
    assert shares_of(found) == pytest.approx(expected)
    assert [*shares_of(found)] == [*expected]
    assert found.means == {"a": {-1: -3.0, 1: 3.0}, "b": {-1: -1.0, 1: 1.0}}
    assert all(math.isnan(one.low) for one in found.shares)
    assert len(found.notes) == 1


def test_shares_of_repeats_are_those_of_statsmodels():
    # (sum_sq − df · mean_sq of the residual) / total sum_sq, from anova_lm of statsmodels 0.14 for
    # the model C(a) * C(b) * C(c).
    expected = {
        ("a",): 0.566834,
        ("b",): 0.288011,
        ("c",): 0.001278,
        ("a", "b"): 0.032420,
        ("a", "c"): 0.0,  # −0.001096
        ("b", "c"): 0.000365,
        REST: 0.003857,
        SEED: 0.108331,
    }
    assert shares_of(decompose(LEVELS, noisy_scores())) == pytest.approx(expected, abs=1e-6)


def test_shares_are_those_of_nested_least_squares():
    """The sum of squares of an effect is what it adds to the fit of a linear model."""
    scores = noisy_scores()
    at = np.indices(scores.shape).reshape(4, -1)
    columns = [[at[axis] == value for value in range(scores.shape[axis])] for axis in range(3)]

    def residual(*effects):
        model = [np.ones(scores.size)]
        for effect in effects:
            each = itertools.product(*(columns[axis] for axis in effect))
            model += [np.all(one, axis=0).astype(float) for one in each]
        design = np.stack(model, axis=1)
        fit = design @ np.linalg.lstsq(design, scores.ravel(), rcond=None)[0]
        return ((scores.ravel() - fit) ** 2).sum()

    found = shares_of(decompose(LEVELS, scores))
    noise = residual((0, 1, 2)) / (24 * 4)
    total = residual()
    added = residual((0,), (1,)) - residual((0, 1))
    assert found["a", "b"] == pytest.approx((added - 6 * noise) / total)
    assert found[SEED] == pytest.approx((scores.size - 1) * noise / total)


def test_intervals_contain_the_true_shares():
    a, b = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], indexing="ij")
    # The variances of a, of b and of the seed are 2/3, 1 and 1.
    true = {("a",): 2 / 8, ("b",): 3 / 8, ("a", "b"): 0.0, SEED: 3 / 8}
    rng = np.random.default_rng(0)
    inside = dict.fromkeys(true, 0)
    for _ in range(100):
        scores = (a + 2 * b)[..., None] + rng.normal(0, 1, (3, 2, 10))
        for one in decompose({"a": [0, 1, 2], "b": [0, 1]}, scores).shares:
            inside[one.options] += one.low <= true[one.options] <= one.high
            assert one.low <= one.share <= one.high
    assert min(inside.values()) >= 86


def test_failed_repeats_equal_scores_and_huge_scores_are_handled():
    scores = noisy_scores()[:, :, 0]
    levels = {"a": LEVELS["a"], "b": LEVELS["b"], "fixed": [7]}
    scores[0, 0, :2] = -np.inf
    found = decompose(levels, scores[:, :, None])
    assert (found.failed, found.fixed) == (2, ("fixed",))
    lowest = np.where(np.isfinite(scores), scores, scores[np.isfinite(scores)].min())
    assert shares_of(found) == shares_of(decompose(LEVELS | {"c": [0]}, lowest[:, :, None]))
    for same in (np.zeros((3, 4, 5)), np.full((3, 4, 5), -np.inf)):
        nothing = decompose({"a": LEVELS["a"], "b": LEVELS["b"]}, same)
        assert nothing.shares == ()
        assert nothing.notes
    huge = decompose({"a": LEVELS["a"]}, np.array([[-1e308], [0.0], [1e308]]))
    assert shares_of(huge) == pytest.approx({("a",): 1.0})


def test_a_study_reports_the_importance_of_its_options(gaitsim, tmp_path):
    (tmp_path / "small.toml").write_text(STUDY_TEXT)
    printed = json.loads(gaitsim("study", "small.toml", "--workers", 1, "--json").stdout)
    folder = tmp_path / "studies/small"
    (found,) = gs.importance(folder)
    names = {one.name for one in found.shares}
    pair = "evolution.population × organism.pairs"
    assert names == {"evolution.population", "organism.pairs", pair, *SEED}
    assert found.fixed == ("mutation.count",)
    assert found.unequal
    table = next(one.rows for one in sections(folder) if one.title == found.title)
    assert {row[0] for row in table} == names
    assert (folder / "importance.png").stat().st_size > 1000
    (values,) = printed["importance"]
    assert [one["share"] for one in values["shares"]] == [one.share for one in found.shares]
    assert list_folders([tmp_path / "studies"])[0].state == "finished"
    figure = importance_figure([found])
    (axes,) = figure.axes
    widths = [bar.get_width() for bar in axes.patches]
    assert widths == pytest.approx([100 * one.share for one in found.shares])

    next((folder / "cells").iterdir()).unlink()
    with pytest.raises(gs.GaitsimError, match="3 of 4 cells"):
        gs.importance(folder)
    (folder / STUDY).unlink()
    with pytest.raises(gs.GaitsimError, match="not the folder of a study"):
        gs.importance(folder)


@pytest.mark.slow
def test_experiments_are_an_option_only_if_their_scores_are_comparable(gaitsim, tmp_path):
    for others, count in (("millipede-random", 1), ("spider-genetic", 2)):
        text = STUDY_TEXT.replace('["millipede-mutation"]', f'["millipede-mutation", "{others}"]')
        text = text.partition("[axes]")[0] + '[axes]\n"evolution.population" = [5, 9]\n'
        (tmp_path / "two.toml").write_text(text.replace("small", f"two-{count}"))
        gaitsim("study", "two.toml", "--workers", 1)
        found = gs.importance(tmp_path / f"studies/two-{count}")
        assert len(found) == count
        assert ("experiment" in found[0].means) == (count == 1)
        names = [""] if count == 1 else ["millipede-mutation", others]
        assert [one.only for one in found] == names
