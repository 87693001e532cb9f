"""Islands: migration, random streams, and identical results wherever they evolve."""

import itertools
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from breeding import breed
from gaitsim.errors import ExperimentError
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.evolution.islands import migrate
from gaitsim.evolution.repeats import evolve_repeats
from gaitsim.experiment import Islands

THREE = ("islands.number=3", "islands.every=2", "islands.migrants=1", "evolution.generations=7")


def here(experiment):
    return partial(evaluate, experiment)


def in_turn(experiment):
    """Return a stand-in for `Evaluator.map` that runs in this thread and counts its tasks."""

    def parallel_map(function, tasks):
        parallel_map.calls.append((len(tasks), tasks[0].last - tasks[0].first + 1))
        return [function(experiment, task) for task in tasks]

    parallel_map.calls = []
    return parallel_map


def same(one, other):
    for first, second in zip(one, other, strict=True):
        assert np.array_equal(first.genomes, second.genomes)
        assert np.array_equal(first.scores, second.scores)
        assert first.evaluation.terms.keys() == second.evaluation.terms.keys()
        assert (first.number, first.progress, first.diversity, first.stop) == (
            second.number,
            second.progress,
            second.diversity,
            second.stop,
        )


def numbered(islands, population):
    """Genomes whose value is 'island.individual'; higher individuals score less."""
    genomes = np.arange(islands)[:, None, None] + np.arange(population)[None, :, None] / 10.0
    scores = -np.arange(population, dtype=float) + np.zeros((islands, 1))
    return genomes, scores


# Migration


def test_on_a_ring_the_best_migrate_to_the_next_island():
    genomes, scores = numbered(3, 5)
    arrived, values = migrate(Islands(number=3, migrants=2), genomes, scores)
    assert arrived[:, :, 0].tolist() == [
        [0.0, 0.1, 0.2, 2.0, 2.1],
        [1.0, 1.1, 1.2, 0.0, 0.1],
        [2.0, 2.1, 2.2, 1.0, 1.1],
    ]
    assert values.tolist() == [[0, -1, -2, 0, -1]] * 3
    assert genomes[0, 3, 0] == 0.3  # what was there is not changed


def test_with_topology_all_the_best_migrate_to_every_island():
    genomes, scores = numbered(3, 5)
    arrived, _ = migrate(Islands(number=3, migrants=2, topology="all"), genomes, scores)
    assert arrived[:, :, 0].tolist() == [
        [0.0, 1.0, 1.1, 2.0, 2.1],
        [1.0, 0.0, 0.1, 2.0, 2.1],
        [2.0, 0.0, 0.1, 1.0, 1.1],
    ]


@given(
    number=st.integers(1, 5),
    migrants=st.integers(0, 3),
    topology=st.sampled_from(["ring", "all"]),
    seed=st.integers(0, 99),
)
@settings(max_examples=30)
def test_migration_makes_no_island_worse(number, migrants, topology, seed):
    islands = Islands(number=number, migrants=migrants, topology=topology)
    rng = np.random.default_rng(seed)
    genomes = rng.normal(size=(number, 14, 2))
    scores = np.round(rng.normal(size=(number, 14)), 1)  # with equals among them
    arrived, values = migrate(islands, genomes, scores)
    known = {
        tuple(genome): score
        for genome, score in zip(genomes.reshape(-1, 2), scores.flat, strict=True)
    }
    for genome, value in zip(arrived.reshape(-1, 2), values.flat, strict=True):
        assert known[tuple(genome)] == value  # each came with its score
    assert (values.max(axis=1) >= scores.max(axis=1)).all()
    kept = 14 - islands.immigrants
    ordered = -np.sort(-scores, axis=1)
    for island in range(number):
        assert sorted(ordered[island, :kept]) == sorted(
            np.delete(values[island], np.argsort(-scores[island], kind="stable")[kept:])
        )


# Evolving


def test_between_migrations_islands_are_bred_apart(puppet):
    experiment = puppet(*THREE)
    space = experiment.space()
    generations = list(evolve(experiment, here(experiment)))
    assert [generation.progress.evaluations for generation in generations] == [
        18 * number for number in range(1, 8)
    ]
    for before, after in itertools.pairwise(generations):
        genomes, scores = before.genomes.reshape(3, 6, 3), before.scores.reshape(3, 6)
        if before.number % 2 == 0:
            genomes, scores = migrate(experiment.islands, genomes, scores)
        for island in range(3):
            bred = breed(experiment, space, genomes[island], scores[island], after.number, island)
            assert np.array_equal(after.genomes.reshape(3, 6, 3)[island], bred)


def test_one_island_is_a_search_without_islands(puppet):
    plain, experiment = puppet(), puppet("islands.every=1", "islands.migrants=5")
    same(evolve(plain, here(plain)), evolve(experiment, here(experiment)))


@pytest.mark.parametrize("every", [1, 3, 50])
@pytest.mark.parametrize("topology", ["ring", "all"])
def test_epochs_make_the_same_generations(puppet, every, topology):
    experiment = puppet(*THREE, f"islands.every={every}", f"islands.topology={topology}")
    parallel_map = in_turn(experiment)
    whole = list(evolve(experiment, here(experiment)))
    same(whole, evolve(experiment, here(experiment), parallel_map=parallel_map))
    # Each to the next migration; the first generation is bred of none, and made here.
    ends = [min(first + every - 1, 7) for first in range(1, 8, every)]
    lengths = [end - max(begin, 1) for begin, end in itertools.pairwise([0, *ends])]
    assert parallel_map.calls == [(3, length) for length in lengths if length]
    # And from anywhere: the next epoch then ends where it would have ended.
    for begun in whole[:-1]:
        same(
            whole[begun.number :],
            evolve(experiment, here(experiment), begun, parallel_map=in_turn(experiment)),
        )


def test_a_search_stops_within_an_epoch(puppet):
    experiment = puppet(*THREE, "islands.every=5", "evolution.max_evaluations=60")
    found = list(evolve(experiment, here(experiment), parallel_map=in_turn(experiment)))
    assert [generation.number for generation in found] == [1, 2, 3]
    assert found[-1].stop == "another generation would exceed 60 evaluations"


def test_repeats_have_islands_of_their_own(puppet):
    experiment = puppet(*THREE)
    found = list(evolve_repeats(experiment, here(experiment), 4))
    assert np.shape(found) == (7, 4)
    # Without migrants, repeats and islands are the same thing.
    apart = puppet(*THREE, "islands.migrants=0")
    plain = puppet("evolution.generations=7")
    twelve = list(evolve_repeats(plain, here(plain), 12))
    for one, other in zip(evolve_repeats(apart, here(apart), 4), twelve, strict=True):
        assert np.array_equal(one, other.reshape(4, 3).max(axis=1))


# The options


@pytest.mark.parametrize(
    ("overrides", "what", "allowed"),
    [
        (("islands.number=2", "islands.migrants=6"), "6 migrants from the neighbour", "≤ 5"),
        (
            ("islands.number=4", "islands.topology=all"),
            "2 migrants from each of 3 neighbours leave no room in a population of 6",
            "a whole number ≤ 1",
        ),
        (("islands.topology=star",), "invalid islands.topology: star (", '"ring" or "all"'),
        (("islands.count=3",), "unknown key", "number"),
        (("islands=3",), "is a section", "SECTION.OPTION=VALUE"),
        (
            ("islands.number=3", "evolution.max_evaluations=17"),
            "17 evaluations are not enough for 3 populations of 6",
            "≥ 18",
        ),
    ],
)
def test_invalid_islands_are_refused(puppet, overrides, what, allowed):
    with pytest.raises(ExperimentError) as refused:
        puppet(*overrides)
    (problem,) = refused.value.problems
    assert what in problem.what
    assert allowed in problem.allowed
