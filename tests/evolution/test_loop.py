import dataclasses
import math
from functools import partial

import numpy as np
import pytest

from breeding import breed, initial_population
from gaitsim.errors import PluginError
from gaitsim.evaluation import Evaluation, evaluate
from gaitsim.evolution import SearchProgress, evolve

INF = math.inf


def course(puppet, scores, *overrides):
    """The generations of an experiment whose bests are `scores`, one a generation."""
    experiment = puppet("evolution.generations=100", *overrides)
    bests = iter(scores)

    def scored(genomes, number):
        values = np.full(len(genomes), -9.0)
        values[3] = next(bests)
        return Evaluation(values, {"reach": values.copy()}, {})

    return list(evolve(experiment, scored))


def test_generations_follow_one_another_by_breeding(puppet):
    experiment = puppet()
    space = experiment.space()
    generations = list(evolve(experiment, partial(evaluate, experiment)))
    assert [generation.number for generation in generations] == [1, 2, 3, 4, 5]
    genomes = initial_population(experiment, space)
    for generation in generations:
        assert np.array_equal(generation.genomes, genomes)
        assert np.array_equal(generation.scores, evaluate(experiment, genomes).scores)
        assert generation.diversity == space.diversity(genomes)
        assert generation.progress.evaluations == 6 * generation.number
        assert generation.scores[generation.best] == generation.scores.max()
        assert generation.seconds > 0
        genomes = breed(experiment, space, genomes, generation.scores, generation.number + 1)
    bests = [generation.progress.best_score for generation in generations]
    assert bests == sorted(bests)


def test_continuing_from_any_generation_yields_the_same_ones(puppet):
    experiment = puppet()

    def scored(genomes, number):
        return evaluate(experiment, genomes)

    whole = list(evolve(experiment, scored))
    for begun in whole:
        again = list(evolve(experiment, scored, begun))
        assert [generation.number for generation in again] == list(range(begun.number + 1, 6))
        for one, other in zip(again, whole[begun.number :], strict=True):
            assert np.array_equal(one.genomes, other.genomes)
            assert np.array_equal(one.scores, other.scores)
            assert one.progress == other.progress
            assert one.stop == other.stop


def test_generations_and_their_arrays_are_read_only(puppet):
    experiment = puppet()
    generation = next(evolve(experiment, partial(evaluate, experiment)))
    with pytest.raises(dataclasses.FrozenInstanceError):
        generation.number = 2
    with pytest.raises(dataclasses.FrozenInstanceError):
        generation.progress.evaluations = 2
    for array in (generation.genomes, generation.scores, *generation.evaluation.terms.values()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize(
    ("bests", "override", "reason", "number"),
    [
        (range(9), "evolution.generations=3", "3 generations are done", 3),
        (range(9), "evolution.target_score=1.5", "the target score 1.5 is reached", 3),
        (range(9), "evolution.max_evaluations=23", "would exceed 23 evaluations", 3),
        ([1, 3, 3, 2, 3], "evolution.stagnation=3", "no better score for 3 generations", 5),
        ([1, 0, 2, 1, 1, 9], "evolution.stagnation=2", "no better score for 2 generations", 5),
        ([-INF, -INF, 0], "evolution.stagnation=1", "no better score for 1 generation", 2),
    ],
)
def test_each_stop_condition(puppet, bests, override, reason, number):
    generations = course(puppet, bests, override)
    assert len(generations) == number
    assert reason in generations[-1].stop
    assert all(generation.stop == "" for generation in generations[:-1])
    # Nothing follows a generation at which the search had ended.
    experiment = puppet("evolution.generations=100", override)
    assert list(evolve(experiment, pytest.fail, generations[-1])) == []


def test_champions_beat_a_threshold_that_rises_in_steps(puppet):
    generations = course(
        puppet,
        [0.9, 1.0, 1.1, 1.5, 1.6, 3.1, 3.4, 3.5, 3.6],
        "evolution.generations=9",
        "evolution.fitness_threshold=1.0",
        "evolution.delta_fitness=0.5",
    )
    assert [g.is_champion for g in generations] == [0, 0, 1, 0, 1, 1, 0, 0, 1]
    thresholds = [g.progress.threshold for g in generations]
    assert thresholds == [1.0, 1.0, 1.5, 1.5, 2.0, 3.5, 3.5, 3.5, 4.0]


def test_a_search_in_which_all_fail_continues(puppet):
    generations = course(
        puppet, [-INF] * 4, "evolution.generations=4", "evolution.fitness_threshold=0"
    )
    assert generations[-1].progress == SearchProgress(24, -9.0, 3, 0.0)

    def failing(genomes, number):
        scores = np.full(len(genomes), -INF)
        return Evaluation(scores, {"reach": scores.copy()}, dict.fromkeys(range(6), "reach is nan"))

    generations = list(evolve(puppet("evolution.fitness_threshold=0"), failing))
    assert len(generations) == 5
    assert generations[-1].progress == SearchProgress(30, -INF, 4, 0.0)
    assert generations[-1].best == 0
    assert not generations[-1].is_champion


def test_terms_that_change_their_names_are_refused(puppet):
    names = iter([("a", "b"), ("a", "b"), ("b", "a")])

    def scored(genomes, number):
        zeros = np.zeros(len(genomes))
        return Evaluation(zeros, dict.fromkeys(next(names), zeros), {})

    events = evolve(puppet(), scored)
    next(events), next(events)
    with pytest.raises(PluginError, match=r"fitness 'puppet-reach'.* b, a after a, b"):
        next(events)
