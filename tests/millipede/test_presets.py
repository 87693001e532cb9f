"""The presets: the source's five algorithms, and the scores that they reach."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from gaitsim.evaluation.scoring import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment

ALGORITHMS = {
    "random": ("none", "random-search"),
    "crossover": ("single-point", "none"),
    "double-crossover": ("two-point", "none"),
    "mutation": ("none", "bit-flip"),
    "double-mutation": ("none", "bit-flip"),
}


def generations(experiment, seed=0):
    experiment = replace(experiment, seed=seed)
    return list(evolve(experiment, partial(evaluate, experiment)))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_each_algorithm_has_the_parameters_of_the_source(algorithm):
    experiment = load_experiment(f"millipede-{algorithm}", {"evolution.generations": 6})
    assert experiment.evolution.population == 79
    assert experiment.search.elites == 1
    assert experiment.crossover.children == 2
    parts = [experiment.entries[kind].name for kind in ("crossover", "mutation", "selection")]
    assert parts == [*ALGORITHMS[algorithm], "drop-worst"]
    run = generations(experiment)
    assert len(run) == 6
    best = [generation.scores.max() for generation in run]
    assert best == sorted(best)
    space = experiment.space()
    for before, after in pairwise(run):
        assert space.contains(after.genomes)
        np.testing.assert_array_equal(after.genomes[0], before.genomes[before.best])


def test_the_preset_millipede_is_double_mutation():
    one, other = (load_experiment(name) for name in ("millipede", "millipede-double-mutation"))
    assert one.mutation == other.mutation
    assert one.mutation.count == 2
    assert load_experiment("millipede-mutation").mutation.count == 1
    assert replace(one, name="", description="", entries={}) == replace(
        other, name="", description="", entries={}
    )


def test_every_genome_but_the_worst_breeds_once():
    """Without crossover and mutation, only the worst genome changes: the best replaces it."""
    experiment = load_experiment(
        "millipede-mutation", {"mutation.plugin": "none", "evolution.generations": 2}
    )
    before, after = generations(experiment)
    expected = before.genomes.copy()
    expected[np.lexsort((-np.arange(79), before.scores))[0]] = before.genomes[before.best]
    assert sorted(map(bytes, after.genomes)) == sorted(map(bytes, expected))


# Means of 500 seeds are 9.51, 9.99, 9.94 and 10. Means of 20 have standard errors of 0.10 for
# random search and 0.05 for the small pool.
@pytest.mark.parametrize(
    ("name", "size", "lowest", "highest"),
    [
        ("millipede-random", (79, 80), 9.2, 9.75),
        ("millipede-crossover", (35, 37), 9.8, 10),
        pytest.param("millipede-double-mutation", (79, 80), 9.9, 10, marks=pytest.mark.slow),
        pytest.param("millipede-crossover", (79, 80), 10, 10, marks=pytest.mark.slow),
    ],
)
def test_the_optimum_is_reached_after_the_sources_generations(name, size, lowest, highest):
    population, count = size
    experiment = load_experiment(
        name, {"evolution.population": population, "evolution.generations": count}
    )
    bests = [generations(experiment, seed)[-1].scores.max() for seed in range(20)]
    assert lowest <= np.mean(bests) <= highest
