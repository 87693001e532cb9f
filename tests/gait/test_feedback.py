"""Gaits with and without their reflexes, with errors of servo horns."""

import json

import numpy as np
import pytest

from gaitsim.experiment import load_experiment
from gaitsim.gait import check_gait, compare_blind, feedback, with_world
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import feedback_results

BLIND = {"organism.duration": 2.0}
FEELING = {
    **BLIND,
    "organism.reflexes": {"heading": {"limit": 90.0}, "network": {}},
    "organism.evolve": ["heading.gain"],
}
TURN = [{"at": 0.0, "speed": 0.2, "turn": 20.0}]


def trot(overrides):
    experiment = load_experiment("quadruped", overrides)
    return Individual(experiment, 0.0, {}, 1, experiment.starts()["trot"])


def test_a_blind_robot_is_the_robot_without_reflexes():
    feeling, plain = trot(FEELING), trot(BLIND)
    blind = feedback.blinded(feeling)
    assert np.array_equal(blind.genome, plain.genome)
    assert blind.experiment.organism == plain.experiment.organism
    assert np.array_equal(blind.motion["torso"], plain.motion["torso"])


def test_a_blind_robot_keeps_its_drive_and_the_shares_of_its_commands():
    gains = {"organism.drive": TURN, "organism.command_gains": (0.8, 0.7, 0.6)}
    blind = feedback.blinded(trot({**FEELING, **gains})).experiment.organism
    assert not blind.reflexes
    assert not blind.evolve
    assert blind.drive == tuple(TURN)
    assert blind.command_gains == (0.8, 0.7, 0.6)


@pytest.mark.slow
def test_each_draw_is_the_gait_in_that_world(monkeypatch):
    monkeypatch.setattr(feedback, "WORLDS", feedback.WORLDS[:2])
    individual = trot({**FEELING, "organism.drive": TURN})
    done = []
    found = compare_blind(individual, workers=1, advance=done.append)
    assert sum(done) == 2 * 2
    blind = feedback.blinded(individual)
    for one, walks in ((individual, found.feeling), (blind, found.blind)):
        for world, course in zip(feedback.WORLDS, walks.draws, strict=True):
            alone = with_world(one, world)
            frames = round(alone.measures["lasted"] * alone.motion.frame_rate) + 1
            off = alone.motion["orientation"][0, :, 2] - alone.motion["commanded_heading"][0]
            assert course.forward == alone.measures["forward"]
            assert course.yaw == pytest.approx(np.sqrt(np.mean(off[:frames] ** 2)))
            assert course.fell == (alone.measures["lasted"] < 2)
        assert walks.nominal.forward == one.measures["forward"]
        assert walks.nominal.forward * walks.kept == pytest.approx(
            np.mean([course.forward for course in walks.draws])
        )
    assert json.loads(json.dumps(found.to_dict()))["blind"]["yaw"] == found.blind.yaw


@pytest.mark.slow
def test_the_heading_reflex_keeps_the_course():
    found = compare_blind(trot({"organism.reflexes": FEELING["organism.reflexes"]}))
    assert found.reflexes == ("heading", "network")
    assert found.feeling.yaw < found.blind.yaw / 2
    [feeling, blind] = feedback_results(found).rows
    assert feeling[0] == "with reflexes"
    assert feeling[1] != blind[1]


@pytest.mark.parametrize("reflexes", [{}, {"organism.drive": TURN}])
def test_bodies_without_reflexes_are_not_compared(reflexes):
    assert compare_blind(trot({**BLIND, **reflexes})) is None


def test_gaits_from_files_and_other_bodies_are_not_compared():
    feeling = trot(FEELING)
    played = Individual.of_motion(feeling.experiment, feeling.motion)
    assert compare_blind(played) is None
    spider = load_experiment("spider")
    genome = spider.space().random(1, np.random.default_rng(0))[0]
    assert compare_blind(Individual(spider, 0.0, {}, 1, genome)) is None


def test_a_fall_ends_the_course_and_a_backward_gait_keeps_nothing():
    course = feedback.Course(-0.1, 0.0, True)
    walks = feedback.Walks(
        course, (feedback.Course(0.2, 0.3, True), feedback.Course(0, 0.4, False))
    )
    assert walks.falls == 1
    assert np.isnan(walks.kept)
    assert walks.yaw == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
    results = feedback.FeedbackResults(("heading",), walks, walks)
    assert feedback_results(results).rows[0][2] == "–"


@pytest.mark.slow
def test_a_robot_with_reflexes_is_also_checked_with_inexact_horns():
    assert {"joint_offset": 2.0} in trot(FEELING).experiment.organism.checks()
    assert {"joint_offset": 2.0} not in trot(BLIND).experiment.organism.checks()
    names = [one.name for one in check_gait(trot(FEELING), workers=1).checks]
    assert names[-1] == "joint_offset 2"
