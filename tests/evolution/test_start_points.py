"""Searches begin around start points, which walk or fly better than random genomes."""

import numpy as np
import pytest

from gaitsim.errors import ExperimentError
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import ask
from gaitsim.evolution.searching import first_population, initial_state
from gaitsim.experiment import load_experiment

SEARCHES = {
    "cma-es": {},
    "differential-evolution": {},
    "genetic": {},
    "map-elites": {"search.axes": {"yaw": (-1.0, 1.0)}},
    "nsga-2": {"search.objectives": {"forward": "max", "yaw": "min"}},
}


def spider(search, start="body"):
    """Return the spider with a search; genetic algorithms need operators."""
    preset = "spider-genetic" if search == "genetic" else "spider"
    options = {"search.plugin": search, "search.start": start, **SEARCHES.get(search, {})}
    return load_experiment(preset, options)


def scores(experiment, genomes):
    with Evaluator(experiment) as evaluator:
        return evaluator.evaluate(genomes, 1).scores


def assert_equal_genomes(genome, expected, space):
    """Check genomes up to rounding; periodic genes may be at either bound."""
    gaps = np.abs(genome - expected)
    gaps = np.where(space.periodic, np.minimum(gaps, space.width - gaps), gaps)
    np.testing.assert_allclose(gaps, 0, atol=1e-12)


@pytest.mark.parametrize(
    ("preset", "options"),
    [
        ("spider", {}),
        ("spider", {"organism.symmetry": "none", "organism.frequency": 1.0}),
        ("spider", {"organism.encoding": "cpg"}),
        ("fly", {}),
        ("fly", {"organism.wings": "asymmetric"}),
        ("fly", {"organism.wings": "mirrored", "organism.hidden": (4, 5, 6)}),
        ("walker-four", {"organism.duration": 3.0}),
        ("walker-four", {"organism.duration": 3.0, "organism.symmetry": "none"}),
        # In its cases with soft servos, the trot falls before the search adapts it.
        pytest.param("quadruped", {"worlds.cases": ()}, marks=pytest.mark.slow),
        pytest.param("hexapod", {"organism.symmetry": "none"}, marks=pytest.mark.slow),
        pytest.param("hexapod", {"organism.encoding": "cpg"}, marks=pytest.mark.slow),
        pytest.param("spider-physics", {}, marks=pytest.mark.slow),
    ],
)
def test_start_points_score_better_than_nine_in_ten_random_genomes(preset, options):
    experiment = load_experiment(preset, options)
    starts = np.array([*experiment.starts().values()])
    assert len(starts) > 0
    drawn = experiment.space().random(20, np.random.default_rng(0))
    assert (scores(experiment, starts) > np.quantile(scores(experiment, drawn), 0.9)).all()


@pytest.mark.parametrize("search", SEARCHES)
def test_the_first_genome_is_the_start_point(search):
    experiment = spider(search)
    start = experiment.starts()["tetrapod"]
    genomes = first_population(experiment)
    assert_equal_genomes(genomes[0], start, experiment.space())
    assert (genomes[1:] != start).any(axis=1).mean() > 0.7
    chosen = spider(search, "tetrapod")
    assert np.array_equal(first_population(chosen), genomes)


@pytest.mark.parametrize("search", [*SEARCHES, "random"])
def test_without_start_points_a_search_begins_at_random(search):
    experiment = spider(search, "random")
    none = np.empty((0, experiment.space().genes))
    state = initial_state(experiment, experiment.space(), none)
    expected, _ = ask(experiment, experiment.space(), state, None, 1, starts=none)
    genomes = first_population(experiment)
    assert np.array_equal(genomes, expected)
    start = load_experiment("spider").starts()["tetrapod"]
    assert (genomes != start).any(axis=1).all()


def test_several_start_points_come_first():
    experiment = load_experiment("hexapod", {"organism.symmetry": "none"})
    starts = np.array([*experiment.starts().values()])
    assert [*experiment.starts()] == ["tripod", "wave"]
    genetic = load_experiment(
        "hexapod",
        {
            "organism.symmetry": "none",
            "search.plugin": "differential-evolution",
            "search.start_share": 0.5,
        },
    )
    np.testing.assert_array_equal(first_population(genetic)[:2], starts)
    assert_equal_genomes(first_population(experiment)[0], starts[0], experiment.space())


def test_an_unknown_start_point_is_refused_with_those_that_exist():
    with pytest.raises(ExperimentError) as raised:
        load_experiment("spider", {"search.start": "tripod"})
    [problem] = raised.value.problems
    assert problem.what == "the body 'spider' has no start point 'tripod'"
    assert problem.allowed == "body, random, tetrapod"
    with pytest.raises(ExperimentError):
        load_experiment("spider-recurrence", {"search.start": "tetrapod"})
    with pytest.raises(ExperimentError):
        load_experiment("spider", {"search.plugin": "random", "search.start": "body"})
