"""Gaits in several worlds: unseen ones, the checks of a body, and without reflexes."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.errors import PluginError
from gaitsim.evaluation.scoring import evaluate
from gaitsim.evaluation.worlds import draw_unseen_worlds, draw_worlds
from gaitsim.experiment import load_experiment
from gaitsim.gait import check_gait, compare_blind, with_world, worlds
from gaitsim.gait.worlds import (
    CheckResults,
    FeedbackResults,
    Outcome,
    UnseenResults,
    WorldResults,
    evaluate_unseen,
)
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import (
    check_results,
    feedback_results,
    summary_line,
)

EXPERIMENT = load_experiment("walker", {"organism.duration": 1, "worlds.number": 3})
GENOME = EXPERIMENT.space().random(1, np.random.default_rng(3))
SHORT = load_experiment("quadruped", {"organism.duration": 1.0})
TROT = SHORT.starts()["trot"]
BLIND = {"organism.duration": 2.0}
REFLEXES = {"organism.reflexes": {"heading": {"limit": 90.0}, "network": {}}}
FEELING = {**BLIND, **REFLEXES, "organism.evolve": ["heading.gain"]}
TURN = [{"at": 0.0, "speed": 0.2, "turn": 20.0}]


@pytest.fixture(scope="module")
def walker():
    found = evaluate(EXPERIMENT, GENOME)
    return Individual(EXPERIMENT, found.scores[0], found.terms_of(0), 12, GENOME[0])


@pytest.fixture(scope="module")
def unseen(walker):
    return evaluate_unseen(walker, 15, workers=1)


def trot(overrides):
    experiment = load_experiment("quadruped", overrides)
    return Individual(experiment, 0.0, {}, 1, experiment.starts()["trot"])


def walked(distance, fell=False, yaw=np.nan):
    return Outcome(distance, 0.0, fell, yaw=yaw)


class TestUnseenWorlds:
    def test_each_world_is_that_of_a_gait_played_there_alone(self, walker, unseen):
        assert unseen.worlds == draw_unseen_worlds(EXPERIMENT, 15)
        for world, outcome in zip(unseen.worlds[:4], unseen.outcomes, strict=False):
            alone = with_world(walker, world)
            assert (outcome.score, outcome.result) == (alone.score, alone.measures["forward"])
            assert outcome.fell == (alone.measures["lasted"] < 1)
        assert unseen.nominal.score == walker.replayed_score
        assert not {world["seed"] for world in draw_worlds(EXPERIMENT, 1)} & {
            world["seed"] for world in unseen.worlds
        }

    def test_quantiles_are_those_of_numpy(self, unseen):
        results = np.array([outcome.result for outcome in unseen.outcomes])
        assert unseen.median == np.median(results)
        assert unseen.quantile(0.25) == np.percentile(results, 25)
        assert unseen.worst_tenth == np.sort(results)[:2].mean()  # of 15, two
        assert results.argmin() == unseen.worlds.index(unseen.worst)

    @pytest.mark.slow  # two processes start
    def test_the_number_of_workers_and_the_order_change_nothing(self, walker, unseen):
        done = []
        shared = evaluate_unseen(walker, 15, workers=2, advance=done.append)
        assert shared.outcomes == unseen.outcomes
        assert sum(done) == 15

    def test_ranges_are_those_of_the_experiment_without_what_is_fixed(self, walker):
        ranges = {"friction": (0.5, 0.6), "servo_torque": (0.8, 0.9)}
        told = load_experiment("walker", {"organism.duration": 1, "worlds.ranges": ranges})
        changed = with_world(replace(walker, experiment=told), {"friction": 0.2})
        found = evaluate_unseen(changed, 2, seed=4, workers=1)
        assert found.ranges == {"servo_torque": (0.8, 0.9)}
        again = evaluate_unseen(changed, 2, seed=4, ranges=found.ranges)
        assert found.outcomes[0] == again.outcomes[0]
        first = with_world(changed, found.worlds[0])
        assert first.world["friction"] == 0.2
        assert found.outcomes[0].score == first.score

    def test_failed_motions_do_not_spoil_the_description(self):
        results = np.r_[-np.inf, -np.inf, np.arange(18.0)]
        found = made(results, measure="score", unit="", friction=np.linspace(0, 1, 20))
        assert found.worst_tenth == -np.inf
        assert found.median == 7
        assert "worst tenth –" in summary_line(found)


def made(results, fell=None, measure="forward", unit="m", **conditions):
    """Results in unseen worlds with these results."""
    count = len(results)
    fell = np.zeros(count, bool) if fell is None else fell
    return UnseenResults(
        measure,
        unit,
        walked(2.0),
        tuple(
            {name: float(values[at]) for name, values in conditions.items()} for at in range(count)
        ),
        tuple(walked(float(r), bool(f)) for r, f in zip(results, fell, strict=True)),
        {name: (float(v.min()), float(v.max())) for name, v in conditions.items()},
        dict.fromkeys(conditions, "°"),
        0,
    )


def checked(nominal, *outcomes):
    places = tuple({"friction": 0.4 + number} for number in range(len(outcomes)))
    varied = tuple(f"friction {number}" for number in range(len(outcomes)))
    return CheckResults("forward", "m", nominal, places, outcomes, varied)


class TestChecks:
    def test_each_check_is_the_gait_in_that_world(self):
        individual = Individual(SHORT, 0.0, {}, 1, TROT)
        done = []
        found = check_gait(individual, workers=1, advance=done.append)
        assert sum(done) == len(found.worlds) == 6
        for at, (world, outcome) in enumerate(zip(found.worlds, found.outcomes, strict=True)):
            alone = with_world(individual, world)
            assert outcome.result == alone.measures["forward"]
            assert found.kept_in(at) == outcome.result / individual.measures["forward"]
            assert outcome.fell == (alone.measures["lasted"] < 1)

    def test_a_gait_holds_if_it_keeps_three_quarters_and_never_falls(self):
        whole = walked(4.0)
        assert checked(whole, walked(3.1), walked(4.5)).holds
        assert not checked(whole, walked(2.9), walked(4.0)).holds
        assert not checked(whole, walked(3.9, fell=True), walked(4.0)).holds
        assert not checked(walked(4.0, fell=True), walked(4.0)).holds
        assert checked(whole, walked(-np.inf)).kept_in(0) == 0

    def test_a_gait_that_turns_off_its_course_does_not_hold(self):
        turning = walked(4.0, yaw=np.radians(40))
        found = checked(walked(4.0), walked(3.9), turning)
        assert (found.passed, found.worst) == ((True, False), 1)
        assert "turns by 40°" in found.summary
        assert "course" in checked(turning, walked(4.0)).summary

    def test_the_worst_check_is_one_with_a_fall(self):
        found = checked(walked(4.0), walked(2.0), walked(3.0, fell=True), walked(3.9))
        assert found.outcomes[found.worst].fell
        assert found.passed == (False, False, True)
        assert "75 %" in found.summary
        passage = check_results(found)
        assert passage.warning == found.summary
        assert [row[3] for row in passage.rows] == ["", "falls", ""]
        assert found.depends_on == ("friction 0", "friction 1")

    @pytest.mark.parametrize("distance", [0.0, -1.0])
    def test_a_gait_that_goes_nowhere_does_not_hold(self, distance):
        found = checked(walked(distance), walked(1.0))
        assert not found.holds
        assert "nan" not in found.summary

    @pytest.mark.parametrize(
        ("checks", "message"),
        [
            ([{"frction": 1.0}], "names an invalid check: unknown condition 'frction'"),
            (None, "failed while naming its checks"),
        ],
    )
    def test_a_wrong_check_is_an_error_of_the_plugin(self, checks, message, monkeypatch):
        monkeypatch.setattr(type(SHORT.organism), "checks", lambda body: checks)
        with pytest.raises(
            PluginError, match=f"organism 'robot' of package gaitsim-robot .* {message}"
        ):
            check_gait(Individual(SHORT, 0.0, {}, 1, TROT))

    def test_other_bodies_have_no_checks(self, walker):
        assert check_gait(walker) is None

    @pytest.mark.slow
    def test_a_robot_with_reflexes_is_also_checked_with_inexact_horns(self):
        assert {"joint_offset": 2.0} in trot(FEELING).experiment.organism.checks()
        assert {"joint_offset": 2.0} not in trot(BLIND).experiment.organism.checks()


class TestReflexes:
    def test_a_blind_robot_is_the_robot_without_reflexes(self):
        feeling, plain = trot(FEELING), trot(BLIND)
        blind = worlds.blinded(feeling)
        assert np.array_equal(blind.genome, plain.genome)
        assert blind.experiment.organism == plain.experiment.organism
        assert np.array_equal(blind.motion["torso"], plain.motion["torso"])

    def test_a_blind_robot_keeps_its_drive_and_the_shares_of_its_commands(self):
        gains = {"organism.drive": TURN, "organism.command_gains": (0.8, 0.7, 0.6)}
        blind = worlds.blinded(trot({**FEELING, **gains})).experiment.organism
        assert not blind.reflexes
        assert not blind.evolve
        assert blind.drive == tuple(TURN)
        assert blind.command_gains == (0.8, 0.7, 0.6)

    @pytest.mark.slow
    def test_each_draw_is_the_gait_in_that_world(self, monkeypatch):
        monkeypatch.setattr(worlds, "HORN_WORLDS", worlds.HORN_WORLDS[:2])
        individual = trot({**FEELING, "organism.drive": TURN})
        done = []
        found = compare_blind(individual, workers=1, advance=done.append)
        assert sum(done) == 2 * 2
        blind = worlds.blinded(individual)
        for one, results in ((individual, found.feeling), (blind, found.blind)):
            for world, outcome in zip(results.worlds, results.outcomes, strict=True):
                alone = with_world(one, world)
                frames = round(alone.measures["lasted"] * alone.motion.frame_rate) + 1
                off = alone.motion["orientation"][0, :, 2] - alone.motion["commanded_heading"][0]
                assert outcome.result == alone.measures["forward"]
                assert outcome.yaw == pytest.approx(np.sqrt(np.mean(off[:frames] ** 2)))
                assert outcome.fell == (alone.measures["lasted"] < 2)
            assert results.nominal.result == one.measures["forward"]

    @pytest.mark.slow
    def test_the_heading_reflex_keeps_the_course(self):
        found = compare_blind(trot(REFLEXES))
        assert found.reflexes == ("heading", "network")
        assert found.feeling.yaw < found.blind.yaw / 2
        [feeling, blind] = feedback_results(found).rows
        assert feeling[0] == "with reflexes"
        assert feeling[1] != blind[1]

    @pytest.mark.parametrize("reflexes", [{}, {"organism.drive": TURN}])
    def test_bodies_without_reflexes_are_not_compared(self, reflexes):
        assert compare_blind(trot({**BLIND, **reflexes})) is None

    def test_gaits_from_files_and_other_bodies_are_not_compared(self, walker):
        feeling = trot(FEELING)
        assert compare_blind(Individual.of_motion(feeling.experiment, feeling.motion)) is None
        assert compare_blind(walker) is None

    def test_a_backward_gait_keeps_nothing(self):
        outcomes = walked(0.2, fell=True, yaw=0.3), walked(0.0, yaw=0.4)
        found = WorldResults("forward", "m", walked(-0.1), ({}, {}), outcomes)
        assert found.falls == 1
        assert found.mean == pytest.approx(0.1)
        assert found.yaw == pytest.approx(np.sqrt((0.09 + 0.16) / 2))
        assert feedback_results(FeedbackResults(("heading",), found, found)).rows[0][2] == "–"
