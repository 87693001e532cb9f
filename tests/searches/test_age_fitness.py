"""Age-fitness Pareto optimisation: who survives, and how old children are."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import Context, RealSpace, Results
from gaitsim_searches.age_fitness import AgeFitness

SPACE = RealSpace(np.full(2, -5.0), np.full(2, 5.0))


class Copies:
    """Operators that copy the mother."""

    def cross(self, genomes, parents, children):
        return genomes[parents[:, 0]]

    def mutate(self, genomes):
        return genomes.copy()


def context(generation=2, population=4):
    """Return a context whose operators copy."""
    return Context(
        space=SPACE,
        population=population,
        generation=generation,
        rng=np.random.default_rng(generation),
        operators=Copies(),
    )


def state_of(scores, ages):
    """Return a state with survivors, whose first gene is their number."""
    genomes = np.stack([np.arange(len(scores)) / 10, np.zeros(len(scores))], axis=1)
    return {
        "genomes": genomes,
        "scores": np.array(scores, float),
        "ages": np.array(ages, np.int64),
        "young": np.zeros(4, np.int64),
    }


def test_the_young_survive_with_lower_scores():
    """The fronts of high score and low age survive; the dominated go first, worst first."""
    state = state_of([5.0, 4.0, 3.0, 2.0], [9, 8, 9, 3])
    young = np.array([[1.0, 0], [2, 0], [3, 0], [4, 0]])
    results = Results(young, np.array([1.0, 0.5, -np.inf, 0.2]))
    found = AgeFitness().tell(state, results, context())
    # On the first front: 5 (age 10), 4 (9), 2 (4), and the newest with 1.
    assert sorted(found["scores"]) == [1.0, 2.0, 4.0, 5.0]
    assert sorted(found["ages"]) == [1, 4, 9, 10]


def test_children_are_as_old_as_their_older_parent_and_newcomers_are_new():
    """Ages follow the oldest genes."""
    search = AgeFitness(newcomers=2)
    state = state_of([1.0, 2.0, 3.0, 4.0], [5, 6, 7, 8])
    genomes, asked = search.ask(state, None, context(population=40))
    mothers = np.rint(genomes[:-2, 0] * 10).astype(int)
    assert (asked["young"][:-2] >= state["ages"][mothers]).all()
    assert (asked["young"][-2:] == 0).all()
    assert not np.isin(genomes[-2:, 0], state["genomes"][:, 0]).any()


def test_it_needs_room_for_its_newcomers():
    """A population of newcomers alone would never breed."""
    assert AgeFitness(newcomers=4).objection(SPACE, 4)
    assert not AgeFitness(newcomers=3).objection(SPACE, 4)


@pytest.mark.parametrize("seed", range(3))
def test_it_finds_the_minimum_of_a_sphere(seed):
    """The best score of a sphere approaches 0 with Gaussian mutation."""
    rng, search = np.random.default_rng(seed), AgeFitness()

    class Gaussian(Copies):
        def mutate(self, genomes):
            return SPACE.repair(genomes + rng.normal(0, 0.3, genomes.shape))

    state, last = search.initial(context(1)), None
    for generation in range(1, 61):
        now = replace(context(generation, 40), operators=Gaussian())
        genomes, state = search.ask(state, last, now)
        last = Results(genomes, -np.square(genomes).sum(axis=1))
        state = search.tell(state, last, now)
        assert len(state["genomes"]) == 40
        assert not search.mismatch(state, now)
    assert state["scores"].max() > -0.01
    assert search.figures(state)["age of best"] > search.figures(state)["mean age"] > 1
