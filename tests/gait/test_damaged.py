"""Gaits on damaged bodies."""

import numpy as np
import pytest

from gaitsim.evaluation.scoring import evaluate
from gaitsim.experiment import load_experiment
from gaitsim.gait import with_damage
from gaitsim.individual import Individual
from gaitsim_spider.organism import Spider

EXPERIMENT = load_experiment("spider")
GENOME = EXPERIMENT.space().random(1, np.random.default_rng(3))
DAMAGE = ["L2 lost", "R1 femur stuck 20"]


@pytest.fixture
def whole():
    found = evaluate(EXPERIMENT, GENOME)
    return Individual(EXPERIMENT, found.scores[0], found.terms_of(0), 12, GENOME[0])


def test_a_genome_moves_the_damaged_body_and_is_scored_by_that_motion(whole):
    hurt = with_damage(whole, DAMAGE)
    motion = Spider(damage=tuple(DAMAGE), symmetry="alternating").move(GENOME)
    assert np.array_equal(hurt.motion["pose"], motion["pose"])
    assert hurt.score == pytest.approx(hurt.replayed_score)
    assert hurt.score == pytest.approx(sum(hurt.terms.values()))
    assert hurt.score != whole.score
    assert hurt.title.endswith("best of generation 12, L2 lost, R1 femur stuck 20")
    assert hurt.stem == "generation-12-L2-lost--R1-femur-stuck-20"
    again = with_damage(hurt, [])
    assert (again.score, again.damage) == (pytest.approx(whole.score), ())


def test_a_gait_from_a_file_is_played_on_the_damaged_body(whole):
    played = Individual.of_motion(
        EXPERIMENT, EXPERIMENT.organism.play(whole.motion["joint_angles"])
    )
    hurt = with_damage(played, DAMAGE)
    assert np.array_equal(hurt.motion["pose"], with_damage(whole, DAMAGE).motion["pose"])
