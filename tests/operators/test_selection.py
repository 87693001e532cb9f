"""Each selection against the probabilities that the literature gives for it."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from gaitsim_operators.selection import (
    DropWorst,
    EliteAndLucky,
    Rank,
    Roulette,
    Tournament,
    Truncation,
    spin,
)

PAIRS = 20_000
# Shuffled, so that an operator that confuses positions with ranks fails.
SCORES = np.array([3.0, -4.0, 10.0, 0.5, 7.0, -1.0, 8.0, 2.0])
RANKING = np.argsort(-SCORES)


def _assert_frequencies(chosen, probabilities):
    """Apply a chi-square test to indices; indices with probability 0 must not occur."""
    probabilities = np.asarray(probabilities, dtype=float)
    counts = np.bincount(np.ravel(chosen), minlength=len(probabilities))
    possible = probabilities > 0
    assert counts[~possible].sum() == 0
    expected = probabilities[possible] / probabilities.sum() * counts.sum()
    assert stats.chisquare(counts[possible], expected).pvalue > 1e-3


def _assert_uniform_distinct_pairs(parents, survivors):
    pairs = list(permutations(sorted(survivors), 2))
    place = {pair: i for i, pair in enumerate(pairs)}
    drawn = [place[tuple(pair)] for pair in parents.tolist()]
    _assert_frequencies(drawn, np.ones(len(pairs)))


@pytest.mark.parametrize("size", [1, 2, 3, 7])
def test_tournament_wins_follow_the_closed_form(size):
    count = len(SCORES)
    parents = Tournament(size=size).parents(SCORES, PAIRS, np.random.default_rng(size))
    rank = np.arange(count)
    chances = np.empty(count)
    chances[RANKING] = ((count - rank) ** size - (count - rank - 1) ** size) / count**size
    _assert_frequencies(parents, chances)


def test_tournament_treats_equal_scores_alike():
    parents = Tournament(size=3).parents(np.zeros(6), PAIRS, np.random.default_rng(1))
    _assert_frequencies(parents, np.ones(6))


@pytest.mark.parametrize("pressure", [1.0, 1.1, 1.5, 2.0])
def test_rank_follows_bakers_linear_ranking(pressure):
    count = len(SCORES)
    parents = Rank(pressure=pressure).parents(SCORES, PAIRS, np.random.default_rng(2))
    rank = np.arange(count)
    chances = np.empty(count)
    chances[RANKING] = pressure - (2 * pressure - 2) * rank / (count - 1)
    _assert_frequencies(parents, chances)


def test_rank_depends_on_the_order_of_scores_alone():
    scores = np.where(np.arange(8) == 2, 1e300, SCORES)
    scores[1] = -np.inf
    for seed in range(5):
        np.testing.assert_array_equal(
            Rank().parents(SCORES, 50, np.random.default_rng(seed)),
            Rank().parents(scores, 50, np.random.default_rng(seed)),
        )


def test_roulette_follows_the_scores_above_the_worst():
    parents = Roulette().parents(SCORES, PAIRS, np.random.default_rng(3))
    _assert_frequencies(parents, SCORES + 4)


class _Always:
    """A random generator that always draws the same number."""

    def __init__(self, draw):
        self.draw = draw

    def random(self, shape):
        return np.full(shape, self.draw)


@pytest.mark.parametrize(("draw", "position"), [(0.0, 1), (0.5, 3), (np.nextafter(1, 0), 3)])
def test_roulette_never_chooses_an_individual_with_weight_0(draw, position):
    weights = np.array([0.0, 0.5, 0.0, 0.5, 0.0])
    assert (spin(weights, 2, _Always(draw)) == position).all()


def test_roulette_mothers_and_fathers_are_independent():
    parents = Roulette().parents(SCORES, PAIRS, np.random.default_rng(4))
    table = np.zeros((8, 8))
    np.add.at(table, (parents[:, 0], parents[:, 1]), 1)
    table = np.delete(np.delete(table, 1, axis=0), 1, axis=1)
    assert stats.chi2_contingency(table).pvalue > 1e-3


@pytest.mark.parametrize(
    ("scores", "weights"),
    [
        ([-np.inf, 1.0, 2.0, 4.0], [0, 0, 1, 3]),
        ([-np.inf, 5.0, 5.0, -np.inf], [0, 1, 1, 0]),
        ([-np.inf] * 3, [1, 1, 1]),
        ([-2.5] * 4, [1, 1, 1, 1]),
        ([-1.7e308, 1.7e308, 0.0], [0, 2, 1]),
        ([0.0, 1e-323, 2e-323], [0, 1, 2]),
    ],
    ids=["one failed", "equals beside failures", "all failed", "all equal", "widest", "narrowest"],
)
def test_roulette_with_failed_or_equal_scores(scores, weights):
    parents = Roulette().parents(np.array(scores), 5000, np.random.default_rng(5))
    _assert_frequencies(parents, weights)


@pytest.mark.parametrize(
    ("share", "survivors"), [(0.5, 4), (0.3, 2), (0.01, 2), (1.0, 8), (0.6, 5)]
)
def test_truncation_pairs_the_best(share, survivors):
    parents = Truncation(share=share).parents(SCORES, PAIRS, np.random.default_rng(6))
    _assert_uniform_distinct_pairs(parents, RANKING[:survivors].tolist())


def test_truncation_keeps_the_first_of_equals():
    scores = np.array([1.0, 2.0, 1.0, 1.0])
    parents = Truncation(share=0.5).parents(scores, 200, np.random.default_rng(7))
    assert set(parents.ravel()) == {0, 1}


def test_elite_and_lucky_without_lucky_ones_pairs_the_best():
    selection = EliteAndLucky(elite=4, lucky=0)
    parents = selection.parents(SCORES, PAIRS, np.random.default_rng(8))
    _assert_uniform_distinct_pairs(parents, RANKING[:4].tolist())


def test_lucky_survivors_are_drawn_from_all_the_rest():
    selection = EliteAndLucky(elite=3, lucky=2)
    rest = sorted(RANKING[3:].tolist())
    lucky = []
    for seed in range(1000):
        survivors = set(selection.parents(SCORES, 60, np.random.default_rng(seed)).ravel().tolist())
        assert set(RANKING[:3].tolist()) <= survivors
        assert len(survivors) == 5
        lucky += [rest.index(i) for i in survivors - set(RANKING[:3].tolist())]
    _assert_frequencies(lucky, np.ones(5))


@settings(max_examples=60)
@given(
    population=st.integers(2, 30),
    elite=st.integers(1, 40),
    lucky=st.integers(0, 40),
    seed=st.integers(0, 2**32),
)
def test_elites_survive_and_fill_at_most_the_population(population, elite, lucky, seed):
    scores = -np.arange(population, dtype=float)
    selection = EliteAndLucky(elite=elite, lucky=lucky)
    parents = selection.parents(scores, 3000, np.random.default_rng(seed))
    survivors = set(parents.ravel().tolist())
    best = min(elite, population)
    assert len(survivors) == min(population, elite + lucky)
    assert set(range(best)) <= survivors
    if len(survivors) > 1:
        assert (parents[:, 0] != parents[:, 1]).all()


@given(
    scores=st.lists(st.sampled_from([0.0, 1.0, 2.5, -np.inf]), min_size=2, max_size=31),
    rounds=st.integers(1, 4),
    seed=st.integers(0, 2**32),
)
def test_drop_worst_breeds_every_other_once_a_round(scores, rounds, seed):
    kept = len(scores) - 1
    worst = max(i for i, score in enumerate(scores) if score == min(scores))
    pairs = -(-rounds * kept // 2)
    parents = DropWorst().parents(np.array(scores), pairs, np.random.default_rng(seed))
    turns = parents.ravel()[: rounds * kept]
    expected = np.full(len(scores), rounds)
    expected[worst] = 0
    # An individual is never paired with itself; rounds stay complete nevertheless.
    np.testing.assert_array_equal(np.bincount(turns, minlength=len(scores)), expected)
    for turn in turns.reshape(rounds, kept):
        assert len(set(turn)) == kept
    if kept > 1:
        assert (parents[:, 0] != parents[:, 1]).all()


def test_drop_worst_pairs_at_random():
    drawn = [DropWorst().parents(SCORES, 3, np.random.default_rng(seed))[2] for seed in range(3000)]
    _assert_uniform_distinct_pairs(np.array(drawn), set(range(8)) - {int(RANKING[-1])})


def test_drop_worst_shuffles_each_round():
    scores = np.arange(31.0)
    first, second = DropWorst().parents(scores, 30, np.random.default_rng(9)).reshape(2, 30)
    assert sorted(first) == sorted(second)
    assert (first != second).any()


def test_drop_worst_refuses_an_odd_number_of_parents() -> None:
    assert "79 of 80" in DropWorst().objection(80, 1, 2)
    assert DropWorst().objection(79, 1, 2) == ""
    assert DropWorst().objection(80, 1, 1) == ""


def test_drop_worst_chooses_the_same_in_one_population_and_in_several() -> None:
    scores = np.random.default_rng(1).normal(size=(5, 9))
    alone = DropWorst().parents(scores[0], 4, np.random.default_rng(2))
    np.testing.assert_array_equal(
        DropWorst().parents_each(scores[:1], 4, np.random.default_rng(2))[0], alone
    )
    each = DropWorst().parents_each(scores, 4, np.random.default_rng(3))
    for row, parents in zip(scores, each, strict=True):
        assert sorted(parents.ravel()) == sorted(set(range(9)) - {int(row.argmin())})
