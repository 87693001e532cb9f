"""Worlds that individuals are evaluated in."""

import numpy as np
import pytest

from gaitsim.errors import ExperimentError
from gaitsim.evaluation.scoring import Evaluation, combine_worlds, evaluate, join_evaluations
from gaitsim.evaluation.worlds import draw_unseen_worlds, draw_worlds, in_world
from gaitsim.experiment import Experiment, load_experiment, parse_experiment, with_overrides

SHORT = {"organism.duration": 0.5, "worlds.number": 3}


def walkers(**changes: object) -> Experiment:
    return with_overrides(load_experiment("walker"), SHORT | changes)


def genomes(experiment: Experiment) -> np.ndarray:
    return experiment.space().random(4, np.random.default_rng(1))


@pytest.mark.parametrize(("combine", "count"), [("mean", 3), ("worst", 1), ("worst tenth", 1)])
def test_a_score_is_the_mean_over_the_worst_worlds(combine, count):
    experiment = walkers(**{"worlds.combine": combine})
    people = genomes(experiment)
    alone = [evaluate(in_world(experiment, one), people) for one in draw_worlds(experiment, 1)]
    scores = np.sort([one.scores for one in alone], axis=0)[:count].mean(axis=0)
    found = evaluate(experiment, people)
    np.testing.assert_allclose(found.scores, scores, rtol=1e-12)
    np.testing.assert_array_equal(found.scores, sum(found.terms.values()))


@pytest.mark.filterwarnings("error")
def test_an_individual_that_fails_in_one_world_has_failed():
    experiment = walkers(**{"worlds.number": 2})
    first = Evaluation(np.array([1.0, -np.inf]), {"a": np.array([1.0, np.inf])}, {1: "a is inf"})
    second = Evaluation(np.array([2.0, -np.inf]), {"a": np.array([2.0, -np.inf])}, {1: "a is -inf"})
    found = combine_worlds(experiment, join_evaluations(experiment, [first, second]))
    np.testing.assert_array_equal(found.scores, [1.5, -np.inf])
    assert found.reasons == {1: "a is inf, in world 1 of 2"}


def test_worlds_fill_their_ranges_and_differ_from_unseen_ones():
    experiment = walkers(**{"worlds.number": 20, "worlds.ranges": {"friction": [0.3, 1.2]}})
    worlds = draw_worlds(experiment, 1)
    friction = np.array([one["friction"] for one in worlds])
    np.testing.assert_array_equal(np.sort((friction - 0.3) // 0.045), np.arange(20))
    assert [*worlds[0]] == ["friction", "seed"]
    assert not {*friction} & {one["friction"] for one in draw_unseen_worlds(experiment, 20)}


def test_worlds_without_ranges_leave_out_conditions_that_must_be_named():
    robot = with_overrides(load_experiment("hexapod"), {"worlds.number": 2, "worlds.cases": []})
    drawn = {*draw_worlds(robot, 1)[0]}
    assert {"unevenness", "friction"} < drawn
    assert not {"steps", "rubble"} & drawn
    named = with_overrides(robot, {"worlds.ranges": {"rubble": [0.0, 0.02]}})
    assert {*draw_worlds(named, 1)[0]} == {"rubble", "seed"}


def test_worlds_are_redrawn_when_asked():
    fixed, redrawn = walkers(), walkers(**{"worlds.redraw": 5})
    assert draw_worlds(fixed, 1) == draw_worlds(fixed, 100)
    assert draw_worlds(redrawn, 1) == draw_worlds(redrawn, 5) != draw_worlds(redrawn, 6)
    assert [*redrawn.worlds.redraws(1, 12)] == [6, 11]
    assert not fixed.worlds.redraws(1, 12)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("worlds.ranges", {"frction": [0, 1]}, "friction"),
        ("worlds.ranges.friction", [1.2, 0.3], "from 0 to 5"),
        ("worlds.cases", [{"friction": 1.0}, {"frction": 1.0}], "worlds.cases.1"),
        ("organism.world", {"friction": 9.0}, "0 to 5"),
    ],
)
def test_impossible_worlds_are_refused(key, value, told):
    with pytest.raises(ExperimentError, match=told):
        walkers(**{key: value})


def test_a_body_without_conditions_has_no_worlds():
    with pytest.raises(ExperimentError, match="no conditions that vary between worlds"):
        with_overrides(load_experiment("millipede"), {"worlds.number": 2})


def test_cases_come_before_drawn_worlds_and_all_count():
    cases = [{"friction": 0.3}, {"friction": 1.2, "latency": 0.05}]
    experiment = walkers(**{"worlds.cases": cases, "worlds.number": 1, "worlds.combine": "worst"})
    assert parse_experiment(experiment.to_toml(), "here").worlds == experiment.worlds
    worlds = draw_worlds(experiment, 1)
    assert [*worlds[:2]] == cases
    assert len(worlds) == experiment.worlds.count == 3
    people = genomes(experiment)
    alone = [evaluate(in_world(experiment, one), people).scores for one in worlds]
    np.testing.assert_array_equal(evaluate(experiment, people).scores, np.min(alone, axis=0))
    given = walkers(**{"worlds.cases": cases, "worlds.number": 0, "worlds.redraw": 2})
    assert draw_worlds(given, 3) == given.worlds.cases
    assert not given.worlds.redraws(1, 9)
    mean = np.mean(alone[:2], axis=0)
    np.testing.assert_allclose(evaluate(given, people).scores, mean, rtol=1e-12)
