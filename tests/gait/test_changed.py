"""Gaits on changed bodies."""

import numpy as np
import pytest

from gaitsim.evaluation.scoring import evaluate
from gaitsim.evaluation.worlds import in_world
from gaitsim.experiment import OWN_WORLD, load_experiment
from gaitsim.gait import with_changed_body, with_world
from gaitsim.gait.robustness import measure_robustness
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import explanation

EXPERIMENT = load_experiment("walker", {"organism.duration": 2, "worlds.number": 2})
GENOME = EXPERIMENT.space().random(1, np.random.default_rng(3))


@pytest.fixture
def walker():
    found = evaluate(EXPERIMENT, GENOME)
    return Individual(EXPERIMENT, found.scores[0], found.terms_of(0), 12, GENOME[0])


def test_a_genome_moves_the_changed_body_in_its_own_world(walker):
    moon = with_changed_body(walker, {"organism.gravity": 1.6})
    assert moon.experiment.organism.gravity == 1.6
    assert moon.experiment.worlds == OWN_WORLD
    assert moon.score == evaluate(moon.experiment, GENOME).scores[0] == moon.replayed_score
    assert moon.score != walker.score
    assert moon.label == "generation 12, gravity 1.6"


def test_a_world_changes_only_its_conditions(walker):
    slippery = with_world(walker, {"friction": 0.4})
    weak = with_world(slippery, {"servo_torque": 0.6})
    expected = in_world(EXPERIMENT, {"friction": 0.4, "servo_torque": 0.6})
    assert weak.experiment.organism == expected.organism
    assert weak.score == evaluate(expected, GENOME).scores[0]
    assert weak.stem == "generation-12-friction-0.4--servo-torque-0.6"


def test_a_score_over_worlds_is_not_taken_for_that_of_the_motion(walker):
    assert walker.evaluated_terms() == walker.terms == walker.scored_terms
    assert walker.replayed_score == with_changed_body(walker, {}).score != walker.score
    told = next(explanation(walker, {}))
    assert "over 2 worlds" in told.warning
    assert "changed" not in told.warning
    assert measure_robustness(walker, {}).score == walker.replayed_score
