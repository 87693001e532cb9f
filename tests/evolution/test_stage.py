import math
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from breeding import warm_start_population
from gaitsim.evaluation import evaluate
from gaitsim.evolution import SearchProgress, evolve, reevaluate
from gaitsim.experiment import Evolution

BEFORE = SearchProgress(evaluations=60, best_score=2.5, stagnation=4, threshold=2.6, stage=2)


def test_a_stage_with_new_scores_resets_progress_and_counts_evaluations():
    evolution = Evolution(fitness_threshold=-1.0)
    after = BEFORE.next_stage(evolution.fitness_threshold, reevaluated=True, population=6)
    assert after == SearchProgress(66, -math.inf, -1, -1.0, 3)


def test_a_stage_with_the_same_scores_keeps_progress():
    after = BEFORE.next_stage(Evolution().fitness_threshold, reevaluated=False, population=6)
    assert after == SearchProgress(60, 2.5, 4, 2.6, 3)


def test_a_reevaluated_generation_keeps_its_genomes(puppet):
    experiment, other = puppet(), puppet("fitness.price=1")
    last = next(evolve(experiment, partial(evaluate, experiment)))
    last = replace(last, progress=BEFORE)
    reevaluated = reevaluate(other, last, partial(evaluate, other))
    assert reevaluated.genomes is last.genomes
    assert np.array_equal(reevaluated.scores, evaluate(other, last.genomes).scores)
    assert not np.array_equal(reevaluated.scores, last.scores)
    assert reevaluated.progress == BEFORE
    following = next(evolve(other, partial(evaluate, other), reevaluated))
    assert (following.number, following.progress.stage) == (2, 2)
    assert following.progress.evaluations == 66


def test_a_search_that_remembers_no_genomes_drops_its_history_of_scores(puppet):
    experiment = puppet("search.plugin=cma-es", "evolution.population=8")
    other = puppet("search.plugin=cma-es", "evolution.population=8", "fitness.price=1")
    last = list(islice(evolve(experiment, partial(evaluate, experiment)), 3))[-1]
    assert len(last.state["best scores"]) == 3
    reevaluated = reevaluate(other, last, partial(evaluate, other))
    assert len(reevaluated.state["best scores"]) == 0
    assert reevaluated.progress.evaluations == 24
    np.testing.assert_array_equal(reevaluated.state["mean"], last.state["mean"])


def test_a_warm_start_stays_within_bounds(puppet):
    experiment = puppet("evolution.population=50")
    space = experiment.space()
    genomes = warm_start_population(experiment, space, space.upper)
    assert space.contains(genomes)
    assert np.array_equal(genomes[0], space.upper)
    assert np.array_equal(genomes, warm_start_population(experiment, space, space.upper))
    other = puppet("evolution.population=50", "seed=2")
    assert not np.array_equal(genomes, warm_start_population(other, space, space.upper))
