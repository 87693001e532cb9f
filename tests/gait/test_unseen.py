"""Gaits evaluated in unseen worlds."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.scoring import evaluate
from gaitsim.evaluation.worlds import draw_unseen_worlds, draw_worlds
from gaitsim.experiment import load_experiment
from gaitsim.gait import with_world
from gaitsim.gait.unseen import Outcome, UnseenResults, evaluate_unseen
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import summary_line, world_results

EXPERIMENT = load_experiment("walker", {"organism.duration": 1, "worlds.number": 3})
GENOME = EXPERIMENT.space().random(1, np.random.default_rng(3))

NOWHERE = Outcome(0.0, 0.0, fell=False)


@pytest.fixture(scope="module")
def walker():
    found = evaluate(EXPERIMENT, GENOME)
    return Individual(EXPERIMENT, found.scores[0], found.terms_of(0), 12, GENOME[0])


@pytest.fixture(scope="module")
def unseen(walker):
    return evaluate_unseen(walker, 15, workers=1)


def test_each_world_is_that_of_a_gait_played_there_alone(walker, unseen):
    assert unseen.worlds == draw_unseen_worlds(EXPERIMENT, 15)
    for world, outcome in zip(unseen.worlds[:4], unseen.outcomes, strict=False):
        alone = with_world(walker, world)
        assert (outcome.score, outcome.result) == (alone.score, alone.measures["forward"])
        assert outcome.fell == (alone.measures["lasted"] < 1)
    assert unseen.nominal.score == walker.replayed_score
    assert not {world["seed"] for world in draw_worlds(EXPERIMENT, 1)} & {
        world["seed"] for world in unseen.worlds
    }


def test_quantiles_are_those_of_numpy(unseen):
    results = np.array([outcome.result for outcome in unseen.outcomes])
    assert unseen.median == np.median(results)
    assert unseen.quantile(0.25) == np.percentile(results, 25)
    assert unseen.worst_tenth == np.sort(results)[:2].mean()  # of 15, two
    assert results.argmin() == unseen.worlds.index(unseen.worst)


@pytest.mark.slow  # two processes start
def test_the_number_of_workers_and_the_order_change_nothing(walker, unseen):
    done = []
    shared = evaluate_unseen(walker, 15, workers=2, advance=done.append)
    assert shared.outcomes == unseen.outcomes
    assert sum(done) == 15


def test_ranges_are_those_of_the_experiment_without_what_is_fixed(walker):
    ranges = {"friction": (0.5, 0.6), "servo_torque": (0.8, 0.9)}
    told = load_experiment("walker", {"organism.duration": 1, "worlds.ranges": ranges})
    changed = with_world(replace(walker, experiment=told), {"friction": 0.2})
    found = evaluate_unseen(changed, 2, seed=4, workers=1)
    assert found.ranges == {"servo_torque": (0.8, 0.9)}
    assert found.outcomes[0] == evaluate_unseen(changed, 2, seed=4, ranges=found.ranges).outcomes[0]
    first = with_world(changed, found.worlds[0])
    assert first.world["friction"] == 0.2
    assert found.outcomes[0].score == first.score


def made(results, fell=None, measure="forward", unit="m", **conditions):
    """Results in unseen worlds with these results."""
    count = len(results)
    worlds = tuple(
        {name: float(values[at]) for name, values in conditions.items()} for at in range(count)
    )
    fell = np.zeros(count, bool) if fell is None else fell
    return UnseenResults(
        measure,
        unit,
        Outcome(2.0, 2.0, False),
        {name: (float(v.min()), float(v.max())) for name, v in conditions.items()},
        dict.fromkeys(conditions, "°"),
        0,
        worlds,
        tuple(Outcome(float(r), 0.0, bool(f)) for r, f in zip(results, fell, strict=True)),
    )


def test_results_in_worlds_are_described():
    slope = np.linspace(-3, 3, 120)
    found = made(np.where(np.abs(slope) > 1, 1.6, 1.9), np.abs(slope) > 2.9, side_slope=slope)
    assert summary_line(found) == (
        "In 120 unseen worlds: median 1.60 m, worst tenth 1.60 m, 4 falls; "
        "most sensitive to side slope"
    )
    table, hurting = world_results(found)
    assert ("worst tenth, mean", "1.600", "80 %") in table.rows
    [row] = hurting.rows
    assert row[:4] == ("side_slope", "below −1° or above 1°", "0.300", "4 of 80")


def test_a_gait_that_does_not_move_is_described():
    still = replace(made(np.zeros(20), friction=np.linspace(0, 1, 20)), nominal=NOWHERE)
    table, hurting = world_results(still)
    assert "not move forward in any world" in table.warning
    assert table.columns == ("", "forward m")
    assert hurting.rows == ()


def test_failed_motions_do_not_spoil_the_description():
    found = made(np.r_[-np.inf, -np.inf, np.arange(18.0)], measure="score", unit="",
                 friction=np.linspace(0, 1, 20))  # fmt: skip
    assert found.worst_tenth == -np.inf
    assert found.median == 7
    assert "worst tenth –" in summary_line(found)


@pytest.mark.parametrize(
    ("ranges", "named"),
    [({"ice": (0, 1)}, "ice"), ({"friction": (1.0, 0.5)}, "friction"), ({"mass": (-1, 1)}, "mass")],
)
def test_ranges_that_the_body_cannot_be_in_are_refused(walker, ranges, named):
    with pytest.raises(GaitsimError) as error:
        evaluate_unseen(walker, 3, ranges=ranges)
    assert named in str(error.value)
