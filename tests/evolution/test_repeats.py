from functools import partial

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from breeding import breed, initial_population
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.evolution.repeats import evolve_repeats
from gaitsim.experiment import Experiment, load_experiment, parse_assignments

PRESETS = ("millipede-crossover", "millipede-double-mutation", "spider-recurrence")


def small(name: str, *more: str) -> Experiment:
    return load_experiment(
        name, {"evolution.population": 9, "evolution.generations": 6, **parse_assignments(more)}
    )


@pytest.mark.parametrize("name", PRESETS)
def test_one_repeat_is_bred_as_a_run_is(name: str) -> None:
    experiment = small(name)
    space = experiment.space()
    genomes = initial_population(experiment, space)
    scores = np.random.default_rng(0).normal(size=9)
    np.testing.assert_array_equal(
        breed(experiment, space, genomes[None], scores[None], 2)[0],
        breed(experiment, space, genomes, scores, 2),
    )


@pytest.mark.parametrize("name", PRESETS)
def test_each_repeat_keeps_its_own_elite(name: str) -> None:
    experiment = small(name)
    space = experiment.space()
    genomes = initial_population(experiment, space, populations=7).reshape(7, 9, -1)
    scores = np.random.default_rng(0).normal(size=(7, 9))
    bred = breed(experiment, space, genomes, scores, 2)
    assert bred.shape == genomes.shape
    for before, after, row in zip(genomes, bred, scores, strict=True):
        np.testing.assert_array_equal(after[0], before[row.argmax()])


@pytest.mark.slow
def test_repeats_are_distributed_as_single_runs_are() -> None:
    experiment = small("millipede-double-mutation", "evolution.generations=15")
    *_, last = evolve_repeats(experiment, partial(evaluate, experiment), 150)
    single = []
    for seed in range(150):
        run = small("millipede-double-mutation", "evolution.generations=15", f"seed={seed + 1}")
        *_, end = evolve(run, partial(evaluate, run))
        single.append(end.progress.best_score)
    assert mannwhitneyu(last, single).pvalue > 0.01
    assert abs(last.mean() - np.mean(single)) < 0.6


@pytest.mark.slow
def test_a_part_of_independent_repeats_has_the_same_scores() -> None:
    """Whatever else is evolved with it, also in redrawn worlds."""
    for worlds in ("worlds.number=0", "worlds.number=2"):
        one = small("walker-cma", "evolution.population=5", "organism.duration=0.5", worlds,
                    "worlds.redraw=2")  # fmt: skip
        assert not one.search.several
        whole = list(evolve_repeats(one, partial(evaluate, one), 5))
        part = list(evolve_repeats(one, partial(evaluate, one), 5, only=range(2, 4)))
        np.testing.assert_array_equal(part, np.array(whole)[:, 2:4])
