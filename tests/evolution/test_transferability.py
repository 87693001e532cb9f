"""Tests in reality: predictions, the choice of the next test, and bad input."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import RealSpace
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.worlds import in_reality
from gaitsim.evolution import evolve
from gaitsim.evolution.transferability import NOISE, RealityTests
from gaitsim.experiment import load_experiment, parse_experiment, with_overrides

SPACE = RealSpace(np.zeros(2), np.ones(2), ("a", "b"))
REALITY = {
    "search.plugin": "nsga-2",
    "search.objectives": {"score": "max", "transferability": "max"},
    "transferability.reality": {"world": {"friction": 0.2}},
    "organism.duration": 0.5,
    "evolution.population": 6,
    "evolution.generations": 3,
    "transferability.every": 1,
}


def model_of(features, simulated, real):
    """Tests whose features count as they are."""
    none = RealityTests.none(SPACE)
    count = features.shape[1]
    return replace(
        none,
        features=features,
        simulated=np.asarray(simulated, float),
        real=np.asarray(real, float),
        centre=np.zeros(count),
        spread=np.ones(count),
    )


def matern(distance, scale):
    r = np.sqrt(5) * distance / scale
    return (1 + r + r * r / 3) * np.exp(-r)


def test_a_disparity_is_predicted_as_by_the_textbook():
    rng = np.random.default_rng(3)
    tested, others = rng.normal(size=(5, 3)), rng.normal(size=(7, 3))
    simulated, real = rng.normal(size=5), rng.normal(size=5) - 3
    disparity = np.abs(simulated - real)

    def covariance(one, other):
        return matern(np.linalg.norm(one[:, None] - other, axis=2), np.sqrt(3))

    weights = np.linalg.inv(covariance(tested, tested) + NOISE * np.eye(5))
    mean = disparity.mean()
    expected = mean + covariance(others, tested) @ weights @ (disparity - mean)
    found = model_of(tested, simulated, real).predict(others)
    np.testing.assert_allclose(found, np.maximum(expected, 0), atol=1e-10)


def test_nothing_is_predicted_without_a_test_and_failure_in_reality_costs_the_score():
    assert not RealityTests.none(SPACE).predict(np.ones((4, 3))).any()
    tests = model_of(np.zeros((1, 2)), [3.0], [-np.inf])
    np.testing.assert_allclose(tests.predict(np.array([[9.0, 9.0], [0.0, np.nan]])), 3.0)


def test_the_best_is_tested_first_then_those_most_unlike_the_tested():
    features = np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 0.0], [9.0, 9.0]])
    scores = np.array([1.0, 2.0, 0.5, -np.inf])
    assert RealityTests.none(SPACE).choose(features, scores) == 1
    tests = model_of(features[[1]], [2.0], [1.0])
    assert tests.choose(features, scores) == 2
    tests = model_of(features[:3], [2.0] * 3, [1.0] * 3)
    assert tests.choose(features, scores) is None
    assert tests.choose(features, np.full(4, -np.inf)) is None


def test_an_individual_is_tested_on_the_body_in_reality():
    experiment = with_overrides(load_experiment("walker"), REALITY)
    *_, last = evolve(experiment, lambda genomes, number: evaluate(experiment, genomes, number))
    tests = RealityTests.of(last.state)
    assert tests.generations.tolist() == [1, 2, 3]
    np.testing.assert_array_equal(tests.simulated, evaluate(experiment, tests.genomes).scores)
    body = {"organism.world": {"friction": 0.2}}
    real = with_overrides(load_experiment("walker"), {"organism.duration": 0.5, **body})
    np.testing.assert_array_equal(tests.real, evaluate(real, tests.genomes).scores)
    front = experiment.search.members(last.state).values
    kept = experiment.search.remembered(last.state)
    known = np.flatnonzero((kept[:, None] == tests.genomes[-1]).all(axis=2))
    assert {*front} == {"score", "transferability"}
    assert -last.state["values"][known, 1] == pytest.approx(tests.disparity[-1], rel=0.1)


def test_redrawn_worlds_repeat_tests_in_simulation_and_none_in_reality(monkeypatch):
    redrawn = REALITY | {"worlds.number": 2, "worlds.redraw": 1}
    experiment = with_overrides(load_experiment("walker"), redrawn)
    tested = []

    def in_reality(_, genomes):
        tested.append(len(genomes))
        return np.zeros(len(genomes))

    monkeypatch.setattr("gaitsim.evolution.transferability._in_reality", in_reality)
    *_, last = evolve(experiment, lambda genomes, number: evaluate(experiment, genomes, number))
    assert tested == [1, 1, 1]
    tests = RealityTests.of(last.state)
    np.testing.assert_array_equal(tests.simulated, evaluate(experiment, tests.genomes, 3).scores)


def test_an_experiment_with_reality_is_read_as_it_was_written():
    experiment = with_overrides(load_experiment("walker"), REALITY)
    again = parse_experiment(experiment.to_toml(), "here")
    assert (again.transferability, again.reality) == (
        experiment.transferability,
        experiment.reality,
    )
    assert in_reality(again).organism.world == {"friction": 0.2}
    genetic = {"search.plugin": "cma-es"}
    assert with_overrides(experiment, genetic).reality is None  # that search reads none of it


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("transferability.reality", {}, "the experiment has no body that represents"),
        ("transferability.reality", {"world": {"frction": 1}}, "friction"),
        ("transferability.reality", {"legs": 3}, "2 or 4"),
        ("transferability.reality", {"legs": 4}, "change the genome"),
        ("transferability.every", 0, "≥ 1"),
        ("search.objectives", {"score": "max", "forward": "max"}, "does not use"),
    ],
)
def test_impossible_realities_are_refused(key, value, told):
    with pytest.raises(ExperimentError, match=told):
        with_overrides(load_experiment("walker"), {**REALITY, key: value})


def test_unknown_features_are_refused():
    experiment = with_overrides(
        load_experiment("walker"), {**REALITY, "transferability.features": ["hight"]}
    )
    with pytest.raises(GaitsimError, match=r"no term or measure 'hight'[^!]*transferability"):
        evaluate(experiment, experiment.space().random(2, np.random.default_rng(0)))
