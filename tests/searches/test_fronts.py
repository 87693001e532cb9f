"""Fronts, crowding and hypervolume, against their definitions and closed forms."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from gaitsim_searches.domination import crowding, front_ranks, hypervolume

SHAPES = st.tuples(st.integers(1, 14), st.integers(2, 4))
# Few different values cause many ties and duplicates. ∞ is the cost of a failed individual.
COSTS = SHAPES.flatmap(
    lambda shape: arrays(np.float64, shape, elements=st.sampled_from([0.0, 1.0, 2.0, 3.0, np.inf]))
)


def _dominates(one, other):
    return all(one <= other) and any(one < other)


@settings(max_examples=150, deadline=None)
@given(COSTS)
def test_a_front_is_not_dominated_once_the_previous_fronts_are_removed(costs):
    expected, left, rank = {}, set(range(len(costs))), 0
    while left:
        front = {i for i in left if not any(_dominates(costs[j], costs[i]) for j in left)}
        expected |= dict.fromkeys(front, rank)
        left, rank = left - front, rank + 1
    np.testing.assert_array_equal(front_ranks(costs), [expected[i] for i in range(len(costs))])


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 20), st.integers(2, 4))
def test_crowding_is_the_distance_between_the_neighbours_in_each_objective(seed, count, objectives):
    costs = np.random.default_rng(seed).random((count, objectives))
    ranks = front_ranks(costs)
    expected = np.zeros(count)
    for front in range(ranks.max() + 1):
        members = np.flatnonzero(ranks == front)
        for cost in costs.T:
            ordered = sorted(members, key=lambda one: cost[one])
            width = cost[ordered[-1]] - cost[ordered[0]]
            if width == 0:  # a single individual
                continue
            expected[[ordered[0], ordered[-1]]] = np.inf
            for before, one, after in zip(ordered, ordered[1:], ordered[2:], strict=False):
                expected[one] += (cost[after] - cost[before]) / width
    np.testing.assert_allclose(crowding(costs, ranks), expected)


def test_an_objective_with_equal_values_adds_no_crowding():
    costs = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, 1.0]])
    np.testing.assert_array_equal(crowding(costs, np.zeros(3, np.int64)), 0)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 7), st.integers(2, 5))
def test_hypervolume_is_that_of_a_union_of_boxes(seed, count, objectives):
    # Inclusion and exclusion: the sum of all boxes, minus overlaps of pairs, and so on.
    costs = np.random.default_rng(seed).integers(0, 6, (count, objectives)) / 4
    sides = np.maximum(1 - costs, 0)
    expected = sum(
        (-1) ** (size + 1) * sides[list(some)].min(axis=0).prod()
        for size in range(1, count + 1)
        for some in combinations(range(count), size)
    )
    assert hypervolume(costs, np.ones(objectives)) == pytest.approx(expected)


@pytest.mark.parametrize("objectives", [2, 3, 4])
def test_hypervolume_of_stairs(objectives):
    # Points whose first two costs are i/n and (n-1-i)/n form stairs: slightly more than half.
    count = 50
    first = np.arange(count) / count
    costs = np.full((count, objectives), 0.5)
    costs[:, 0], costs[:, 1] = first, first[::-1]
    stairs = (count + 1) / (2 * count)
    expected = stairs * 0.5 ** (objectives - 2)
    assert hypervolume(costs, np.ones(objectives)) == pytest.approx(expected)
    shuffled = np.random.default_rng(1).permutation(np.repeat(costs, 2, axis=0))
    assert hypervolume(shuffled, np.ones(objectives)) == pytest.approx(expected)


def test_points_beyond_the_reference_add_no_hypervolume():
    reference = np.ones(2)
    assert hypervolume(np.empty((0, 2)), reference) == 0
    assert hypervolume(np.array([[0.0, 1.0], [2.0, -9.0], [np.inf, np.inf]]), reference) == 0
