"""The fly's ready experiments: the source's scheme, and what they reach."""

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
        ("fly", "climb", (15, 20, 20, 3)),
        ("fly-final-altitude", "final-altitude", (15, 20, 20, 3)),
        ("fly-mean-altitude", "mean-altitude", (15, 20, 20, 3)),
        ("fly-asymmetric", "climb", (18, 20, 20, 6)),
    ],
)
def test_presets_are_the_sources_scheme(preset: str, fitness: str, layers: Any) -> None:
    experiment = load_experiment(preset)
    assert experiment.entries["fitness"].name == fitness
    organism: Any = experiment.organism
    assert organism.layers == layers
    assert (organism.duration, organism.dt, organism.control_step) == (3.0, 0.001, 0.01)
    assert (experiment.evolution.population, experiment.evolution.elites) == (100, 5)
    parts = [experiment.entries[kind].name for kind in ("selection", "crossover", "mutation")]
    assert parts == ["truncation", "uniform", "reset"]
    assert experiment.selection.model_dump() == {"share": 0.1}


@pytest.mark.parametrize("preset", ["fly", "fly-asymmetric", "fly-hover"])
def test_better_flies_evolve_within_a_few_generations(preset: str) -> None:
    experiment = load_experiment(preset, ["evolution.generations=12", "evolution.population=40"])
    first = last_generation(
        replace(experiment, evolution=experiment.evolution.model_copy(update={"generations": 1}))
    )
    assert last_generation(experiment).scores.max() > first.scores.max()


def test_a_fly_gains_two_metres() -> None:
    last = last_generation(load_experiment("fly", ["evolution.generations=80"]))
    experiment = load_experiment("fly")
    measures = experiment.organism.measures(experiment.organism.move(last.genomes[last.best][None]))
    assert measures["final altitude"].values[0] >= 2
