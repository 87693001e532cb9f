"""The fly's presets: the parameters of the source, and the altitudes that they reach."""

from dataclasses import replace
from typing import Any

import pytest

from gaitsim.evaluation import Evaluator
from gaitsim.evolution import Generation, evolve
from gaitsim.experiment import Experiment, load_experiment


def last_generation(experiment: Experiment) -> Generation:
    with Evaluator(experiment) as evaluator:
        *_, last = evolve(experiment, evaluator.evaluate)
    return last


@pytest.mark.parametrize(
    ("preset", "fitness", "layers"),
    [
        ("fly-genetic", "climb", (15, 20, 20, 3)),
        ("fly-final-altitude", "final-altitude", (15, 20, 20, 3)),
        ("fly-mean-altitude", "mean-altitude", (15, 20, 20, 3)),
        ("fly-asymmetric", "climb", (18, 20, 20, 6)),
    ],
)
def test_presets_have_the_parameters_of_the_source(preset: str, fitness: str, layers: Any) -> None:
    experiment = load_experiment(preset)
    assert experiment.entries["fitness"].name == fitness
    organism: Any = experiment.organism
    assert organism.layers == layers
    assert (organism.duration, organism.dt, organism.control_step) == (3.0, 0.001, 0.01)
    assert (experiment.evolution.population, experiment.search.elites) == (100, 5)
    parts = [experiment.entries[kind].name for kind in ("selection", "crossover", "mutation")]
    assert parts == ["truncation", "uniform", "reset"]
    assert experiment.selection.model_dump() == {"share": 0.1}


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["fly-genetic", "fly-asymmetric", "fly-hover"])
def test_better_flies_evolve_within_a_few_generations(preset: str) -> None:
    experiment = load_experiment(preset, {"evolution.generations": 12, "evolution.population": 40})
    first = last_generation(
        replace(experiment, evolution=experiment.evolution.model_copy(update={"generations": 1}))
    )
    assert last_generation(experiment).scores.max() > first.scores.max()


@pytest.fixture(scope="module")
def champion() -> Any:
    """Return a champion of an early generation of the default experiment, (1, genes)."""
    last = last_generation(load_experiment("fly-genetic", {"seed": 2, "evolution.generations": 40}))
    return last.genomes[last.best][None]


def final_altitude(champion: Any, **options: float) -> float:
    """Return the mean final altitude over the trials, m."""
    organism = load_experiment("fly").organism
    changed = type(organism)(**{**organism.model_dump(), **options})
    return float(changed.measures(changed.move(champion))["final altitude"].values[0])


@pytest.mark.slow
def test_a_champion_gains_two_metres_and_continues_to_climb(champion: Any) -> None:
    assert final_altitude(champion) >= 2
    assert final_altitude(champion, duration=30.0) >= 20


@pytest.mark.slow
def test_halving_the_time_step_hardly_changes_the_altitude_of_a_champion(champion: Any) -> None:
    whole, half = final_altitude(champion), final_altitude(champion, dt=0.0005)
    assert half == pytest.approx(whole, rel=0.1)
    assert final_altitude(champion, dt=0.00025) == pytest.approx(half, rel=0.05)
