"""Novelty search: distances to neighbours, and who survives."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from gaitsim.contracts import Context, RealSpace, Results
from gaitsim_searches.novelty import MOST, Novelty, novelty

SPACE = RealSpace(np.full(2, -5.0), np.full(2, 5.0))
AXES = {"x": (0.0, 10.0), "y": (0.0, 1.0)}


class Copies:
    """Operators that choose the best, and copy."""

    def parents(self, scores, children):
        best = np.argsort(-scores, kind="stable")
        return np.resize(best, 2 * children).reshape(2, -1).T

    def cross(self, genomes, parents, children):
        return genomes[parents[:, 0]]

    def mutate(self, genomes):
        return genomes.copy()


def context(generation=2, population=4):
    rng = np.random.default_rng(generation)
    return Context(SPACE, population, generation, rng, operators=Copies())


def results(values, scores=None):
    """Return results whose axes are columns of values, and whose genomes are numbered."""
    values = np.array(values, float)
    genomes = np.stack([np.arange(len(values)) / 10, np.zeros(len(values))], axis=1)
    scores = np.zeros(len(values)) if scores is None else np.array(scores, float)
    return Results(genomes, scores, {"x": values[:, 0], "y": values[:, 1]})


@pytest.mark.parametrize("neighbours", [1, 4, 15, 80])
@pytest.mark.parametrize("archived", [0, 30])
def test_novelty_is_the_mean_distance_to_the_nearest_neighbours_by_scipy(neighbours, archived):
    rng = np.random.default_rng(neighbours)
    values, archive = rng.normal(size=(40, 3)), rng.normal(size=(archived, 3))
    everyone = np.concatenate([values, archive])
    known = min(neighbours, len(everyone) - 1)
    distances, _ = cKDTree(everyone).query(values, k=known + 1)
    assert novelty(values, archive, neighbours) == pytest.approx(distances[:, 1:].mean(axis=1))


def test_failed_individuals_are_not_novel_and_no_neighbours():
    values = np.array([[0.0, 0], [1, 0], [np.nan, 0]])
    assert novelty(values, values[:0], 5).tolist() == [1.0, 1.0, -np.inf]
    assert novelty(values[:1], values[:0], 5).tolist() == [0.0]


def test_the_most_novel_survive_whatever_their_scores():
    search = Novelty(axes=AXES, neighbours=1, archived=0)
    crowd = [[5.0, 0.5]] * 6
    told = results([*crowd, [0, 0], [10, 1]], [9.0] * 6 + [-1, -2])
    state = search.tell(search.initial(context()), told, context(population=2))
    assert sorted(state["scores"]) == [-2, -1]


def test_the_fronts_of_novelty_and_score_survive():
    search = Novelty(axes=AXES, goal="both", neighbours=1, archived=0)
    told = results([[5, 0.5], [5, 0.5], [5, 0.5], [0, 0], [9, 1]], [9, 8, 7, 1, np.inf * -1])
    state = search.tell(search.initial(context()), told, context(population=2))
    assert sorted(state["scores"]) == [1, 9]


def test_random_children_enter_the_archive_and_repel_others():
    search = Novelty(axes=AXES, neighbours=3, archived=2)
    state = search.tell(search.initial(context()), results([[0, 0]] * 4), context())
    assert state["archive"].shape == (2, 2)
    for generation in range(3, 6):
        state = search.tell(state, results([[0, 0]] * 4), context(generation))
    assert len(state["archive"]) == 8
    assert search.figures(state) == {"novelty": 0.0, "archive": 8.0}
    full = {**state, "archive": np.zeros((MOST, 2))}
    after = search.tell(full, results([[10, 1]] * 4), context())
    assert len(after["archive"]) == MOST
    assert (after["archive"][-2:] == 1).all()


def test_new_scores_empty_the_archive():
    search = Novelty(axes=AXES)
    state = search.tell(search.initial(context()), results([[0, 0]] * 4), context())
    again = search.rescored(state, results([[1, 1]] * 4, [1, 2, 3, 4]), context())
    assert not len(again["archive"])
    assert again["scores"].tolist() == [1, 2, 3, 4]
    assert not search.mismatch(again, context())
    assert "different axes" in Novelty(axes={"z": (0, 1)}).mismatch(again, context())


@pytest.mark.parametrize("axes", [{}, {"x": (1, 1)}, {"x": (2, 1)}, {"x": (0, 1e300)}])
def test_axes_need_two_ends(axes):
    with pytest.raises(ValueError, match=r"ascend|at least one measure|must be from"):
        Novelty(axes=axes)


@pytest.mark.parametrize(("goal", "reached"), [("novelty", True), ("score", False)])
def test_it_finds_what_lies_away_from_where_scores_lead(goal, reached):
    """Scores rise towards a dead end; the goal lies in the opposite corner."""
    rng = np.random.default_rng(0)

    class Steps(Copies):
        def mutate(self, genomes):
            return SPACE.repair(genomes + rng.normal(0, 0.25, genomes.shape))

    axes = {"x": (-5, 5), "y": (-5, 5)} if goal == "novelty" else {"score": (-20, 100)}
    search, best = Novelty(axes=axes), -np.inf
    state, last = search.initial(context(1)), None
    for generation in range(1, 150):
        now = replace(context(generation, 20), operators=Steps())
        genomes = np.full((20, 2), -4.0) + rng.normal(0, 0.1, (20, 2))
        if last is not None and goal == "novelty":
            genomes, state = search.ask(state, last, now)
        elif last is not None:
            kept = last.genomes[np.argsort(-last.scores)[:4]]
            genomes = Steps().mutate(np.resize(kept, (20, 2)))
        beyond = (genomes > 4).all(axis=1)
        scores = np.where(beyond, 100.0, -np.abs(genomes + 4).sum(axis=1))
        columns = {"x": genomes[:, 0], "y": genomes[:, 1], "score": scores}
        last = Results(genomes, scores, {name: columns[name] for name in axes})
        state = search.tell(state, last, now)
        best = max(best, scores.max())
    assert (best == 100) == reached
