"""Trial and error: predictions against the textbook and closed forms, and when the trials end."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait import play_on_twin
from gaitsim.gait.changed import with_damage
from gaitsim.gaussian_process import posterior
from gaitsim.individual import Individual
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_adaptation.adaptation import Adaptation
from gaitsim_adaptation.prior import Prior, read_prior
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import (
    Trial,
    best_of,
    check_measured,
    ending,
    most_promising,
    predict_performance,
    propose,
    simulated_robot,
    transfer_map,
)

SETTINGS = AdaptationSettings()


def prior_of(performance, behaviour):
    count = len(performance)
    return Prior(
        SimpleNamespace(name="none"),
        Path("atlas"),
        1,
        "forward",
        "m",
        np.arange(count, dtype=float)[:, None],
        np.zeros(count),
        ("a",),
        np.asarray(behaviour, float).reshape(count, -1),
        np.asarray(performance, float),
    )


def random_prior(members=60, axes=3, seed=1):
    rng = np.random.default_rng(seed)
    return prior_of(rng.random(members) * 2, rng.random((members, axes)))


def textbook(prior, points, tried, measured, length, noise):
    """Evaluate eq. 2.25, 2.26 and 4.17 of Rasmussen and Williams 2006 with inverses and loops."""

    def k(a, b):
        r = math.dist(a, b) * math.sqrt(5) / length
        return (1 + r + r * r / 3) * math.exp(-r)

    known = np.array([[k(points[a], points[b]) for b in tried] for a in tried])
    inverse = np.linalg.inv(known + noise * np.eye(len(tried)))
    means, deviations = [], []
    for point, expected in zip(points, prior, strict=True):
        row = np.array([k(point, points[one]) for one in tried])
        means.append(expected + row @ inverse @ (measured - prior[tried]))
        deviations.append(math.sqrt(max(1 - row @ inverse @ row, 0)))
    return np.array(means), np.array(deviations)


def test_the_posterior_is_that_of_the_textbook():
    rng = np.random.default_rng(2)
    prior, points, tried = rng.random(50), rng.random((50, 4)), np.array([3, 17, 44, 8, 20])
    measured = rng.random(5)
    found = posterior(prior, points, tried, measured, 0.4, 0.001)
    mean, deviation = textbook(prior, points, tried, measured, 0.4, 0.001)
    np.testing.assert_allclose(found.mean, mean, atol=1e-10)
    np.testing.assert_allclose(found.deviation, deviation, atol=1e-7)


def test_one_trial_has_a_closed_form():
    prior = prior_of([1.0, 0.8], [[0.0], [0.2]])  # one length scale apart
    belief = predict_performance(prior, [Trial(1, 1, 1.0, 1.0, (0.5,))], SETTINGS)
    r = math.sqrt(5)
    k = (1 + r + r * r / 3) * math.exp(-r)
    assert belief.mean == pytest.approx([1 - 0.5 / 1.001, 0.8 - 0.5 * k / 1.001])
    assert belief.deviation == pytest.approx(
        [math.sqrt(1 - 1 / 1.001), math.sqrt(1 - k * k / 1.001)]
    )


def test_the_unit_of_performance_does_not_matter():
    prior = random_prior()
    scaled = replace(prior, performance=1000 * prior.performance)
    one = [*Adaptation.unsaved(prior, lambda gait: 0.1 * gait.genome[0] / 60, SETTINGS)]
    other = [*Adaptation.unsaved(scaled, lambda gait: 100 * gait.genome[0] / 60, SETTINGS)]
    assert [trial.member for trial in one] == [trial.member for trial in other]


def test_the_first_proposal_is_the_best_of_the_map_and_ties_go_to_the_first_member():
    assert propose(prior_of([1, 3, 3], [[0], [0.5], [1]]), [], SETTINGS).member == 2


def test_trials_leave_a_region_in_which_the_map_is_wrong():
    # Gaits near the peak of the map fail; farther away, gaits perform as the map predicts.
    behaviour = np.linspace(0, 3, 31)
    predicted = 1 - 0.1 * behaviour
    real = np.where(behaviour < 1, 0.0, predicted)
    trials = [
        *Adaptation.unsaved(
            prior_of(predicted, behaviour), lambda g: real[int(g.genome[0])], SETTINGS
        )
    ]
    assert best_of(trials).measured >= 0.9 * real.max()
    assert len(trials) < 8
    assert len({trial.member for trial in trials}) == len(trials)


def test_trials_end_when_one_is_good_enough():
    prior = random_prior()
    trials = [
        *Adaptation.unsaved(prior, lambda gait: prior.performance[int(gait.genome[0])], SETTINGS)
    ]
    assert len(trials) == 1
    assert "95%" in ending(prior, trials, SETTINGS)
    assert propose(prior, trials, SETTINGS) is None
    assert propose(prior, trials, replace(SETTINGS, stop=10.0)).number == 2


def test_trials_end_at_their_maximum_number_and_when_all_gaits_were_tried():
    prior = random_prior(5)
    failed = [*Adaptation.unsaved(prior, lambda gait: 0.0, replace(SETTINGS, trials=3))]
    assert len(failed) == 3
    every = [*Adaptation.unsaved(prior, lambda gait: -1.0, SETTINGS)]
    assert sorted(trial.member for trial in every) == [1, 2, 3, 4, 5]
    assert "all 5" in ending(prior, every, SETTINGS)


@pytest.mark.parametrize("value", [math.nan, math.inf, "far", None])
def test_a_value_that_is_not_a_number_is_refused(value):
    with pytest.raises(GaitsimError, match="finite"):
        check_measured(value, 1)


def test_the_map_of_an_atlas_has_the_performance_of_its_members_on_the_intact_body(puppet_run):
    axes = "{ reach = [-3, 3], price = [-0.2, 0] }"
    run = puppet_run("search.plugin=map-elites", f"search.axes={axes}", "search.cells=30")
    done = []
    prior = read_prior(run, "reach", on_progress=done.append)
    members = run.members
    assert sum(done) == len(members.scores) == len(prior.performance)
    np.testing.assert_allclose(prior.performance, np.sin(members.genomes).sum(axis=1))
    np.testing.assert_allclose(prior.behaviour[:, 0], (members.values["reach"] + 3) / 6)
    np.testing.assert_allclose(prior.behaviour[:, 1].min(), 0)  # a cell at the border
    assert prior.individual(2).measures["reach"] == prior.performance[1]
    for damaged in (None, slice(0, -8), slice(1, None)):  # the cache is validated
        cache = next(Path("run/adaptations").iterdir())
        if damaged:
            cache.write_bytes(cache.read_bytes()[damaged])
        reread = read_prior(RunSnapshot(run.path), "reach").performance
        np.testing.assert_array_equal(reread, prior.performance)
    with pytest.raises(GaitsimError, match="unknown measure 'forward'"):
        read_prior(run)


def test_simulated_trials_use_the_damaged_body_or_its_damaged_twin():
    experiment = load_experiment("spider")
    genome = experiment.space().random(1, np.random.default_rng(5))[0]
    gait = Individual(experiment, 0.0, {}, 1, genome)
    lost = ["L2 lost"]
    moved = {"forward": with_damage(gait, lost), "lateral": play_on_twin(gait, lost)}
    for physics, (measure, individual) in enumerate(moved.items()):
        measured = simulated_robot(experiment, lost, measure, physics=bool(physics))
        assert measured(gait) == individual.measures[measure] != gait.measures[measure]
    for physics in (False, True):
        with pytest.raises(GaitsimError, match="L9"):
            simulated_robot(experiment, ["L9 lost"], physics=physics)


def test_measured_gaits_scale_the_map_of_another_body():
    prior = prior_of([2.0, 0.0, 1.0, 4.0, 3.0], range(5))
    assert most_promising(prior, 9) == (4, 5, 1, 3)
    found = transfer_map(prior, {4: 2.0, 5: 2.1, 1: 1.6})
    np.testing.assert_allclose(found.performance, [1.6, 0.0, 0.7, 2.0, 2.1])
