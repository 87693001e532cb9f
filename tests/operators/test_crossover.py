"""Crossovers: the parent of each gene, and the distribution of mixed genes."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError
from scipy import stats

from gaitsim.contracts import BitSpace, RealSpace
from gaitsim_operators.crossover import (
    Blend,
    NoCrossover,
    SimulatedBinary,
    SinglePoint,
    TwoPoint,
    Uniform,
)

PAIRS = 20_000


def _bits(genes):
    return BitSpace(tuple(str(i) for i in range(genes)))


def _reals(genes, *, lower=-1.0, upper=1.0, periodic=None):
    labels = tuple(str(i) for i in range(genes))
    return RealSpace(np.full(genes, lower), np.full(genes, upper), labels, periodic=periodic)


def _from_father(crossover, genes, pairs=PAIRS, seed=0):
    """Return whether each gene of the first and of the second children is the father's."""
    mothers = np.zeros((pairs, genes), dtype=np.uint8)
    children = crossover.cross(mothers, mothers + 1, _bits(genes), np.random.default_rng(seed))
    return children.reshape(crossover.children, pairs, genes).astype(bool)


def test_single_point_has_one_child_per_pair_by_default_and_others_two():
    assert SinglePoint().children == 1
    for crossover in (TwoPoint(), Uniform(), Blend(), SimulatedBinary(), NoCrossover()):
        assert crossover.children == 2
    with pytest.raises(ValidationError):
        SinglePoint(children=3)


@pytest.mark.parametrize("crossover", [SinglePoint, TwoPoint, Uniform, NoCrossover])
def test_second_children_have_the_other_genes(crossover):
    first, second = _from_father(crossover(children=2), 9)
    np.testing.assert_array_equal(first, ~second)


@pytest.mark.parametrize(
    "crossover", [SinglePoint, TwoPoint, Uniform, SimulatedBinary, NoCrossover]
)
def test_a_single_child_equals_the_first_of_two(crossover):
    space = _reals(7)
    mothers, fathers = space.random(2000, np.random.default_rng(1)).reshape(2, 1000, 7)
    one = crossover(children=1).cross(mothers, fathers, space, np.random.default_rng(2))
    two = crossover(children=2).cross(mothers, fathers, space, np.random.default_rng(2))
    np.testing.assert_array_equal(one, two[:1000])


def test_single_point_cuts_once_and_anywhere():
    genes = 12
    (child,) = _from_father(SinglePoint(), genes)
    cuts = genes - child.sum(axis=1)
    # The mother's genes first, then the father's.
    np.testing.assert_array_equal(child, np.arange(genes) >= cuts[:, None])
    counts = np.bincount(cuts, minlength=genes + 1)
    assert counts[0] == counts[genes] == 0
    assert stats.chisquare(counts[1:genes]).pvalue > 1e-3


@pytest.mark.parametrize(("genes", "cut"), [(2, 1), (7, 3), (48, 24)])
def test_single_point_can_cut_in_the_middle(genes, cut):
    (child,) = _from_father(SinglePoint(point="half"), genes, pairs=5)
    np.testing.assert_array_equal(child, np.tile(np.arange(genes) >= cut, (5, 1)))


@pytest.mark.parametrize("crossover", [SinglePoint(), SinglePoint(point="half"), TwoPoint()])
def test_single_point_cuts_short_genomes(crossover):
    (first, *_) = _from_father(crossover, 1, pairs=10)
    assert not first.any()
    (first, *_) = _from_father(crossover, 2, pairs=10)
    np.testing.assert_array_equal(first, np.tile([False, True], (10, 1)))


@pytest.mark.parametrize("genes", [3, 7])
def test_two_point_cuts_twice_and_anywhere(genes):
    first, _ = _from_father(TwoPoint(), genes, seed=3)
    possible = {
        tuple((np.arange(genes) >= one) & (np.arange(genes) < other)): 0
        for one, other in combinations(range(1, genes), 2)
    }
    for child in first.tolist():
        possible[tuple(child)] += 1  # A KeyError is a child that two cuts cannot make.
    if len(possible) > 1:
        assert stats.chisquare(list(possible.values())).pvalue > 1e-3


@pytest.mark.parametrize("probability", [0.0, 0.2, 0.5, 1.0])
def test_uniform_exchanges_each_gene_independently(probability):
    genes = 4
    first, _ = _from_father(Uniform(probability=probability), genes, seed=4)
    counts = np.bincount(first.sum(axis=1), minlength=genes + 1)
    expected = stats.binom(genes, probability).pmf(np.arange(genes + 1)) * PAIRS
    if probability in (0.0, 1.0):
        np.testing.assert_array_equal(counts, expected)
        return
    assert stats.chisquare(counts, expected).pvalue > 1e-3
    assert stats.chisquare(first.sum(axis=0)).pvalue > 1e-3


@pytest.mark.parametrize("alpha", [0.0, 0.5, 2.0])
def test_blend_is_uniform_around_the_parents(alpha):
    space = _reals(1)
    mothers, fathers = np.full((PAIRS, 1), 0.5), np.full((PAIRS, 1), -0.3)
    children = Blend(alpha=alpha).cross(mothers, fathers, space, np.random.default_rng(5))
    width = 0.8 * (1 + 2 * alpha)
    interval = stats.uniform(-0.3 - 0.8 * alpha, width)
    first, second = children.reshape(2, PAIRS)
    for child in (first, second):
        assert stats.kstest(child, interval.cdf).pvalue > 1e-3
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.03


@pytest.mark.parametrize("eta", [0.0, 2.0, 15.0])
def test_spread_factor_of_simulated_binary(eta):
    space = _reals(2)
    mothers, fathers = np.tile([0.5, -0.2], (PAIRS, 1)), np.tile([-0.3, 0.7], (PAIRS, 1))
    crossover = SimulatedBinary(eta=eta)
    children = crossover.cross(mothers, fathers, space, np.random.default_rng(6))
    first, second = children.reshape(2, PAIRS, 2)
    signed = (first - second) / (mothers - fathers)

    def cdf(spread):
        power = eta + 1
        return np.where(spread <= 1, 0.5 * spread**power, 1 - 0.5 * np.maximum(spread, 1) ** -power)

    for gene in range(2):
        assert stats.kstest(np.abs(signed[:, gene]), cdf).pvalue > 1e-3
    # For each gene, a random child gets the lower value.
    sides = np.bincount(2 * (signed[:, 0] > 0) + (signed[:, 1] > 0))
    assert stats.chisquare(sides).pvalue > 1e-3


def test_simulated_binary_inherits_genes_that_are_not_crossed():
    space = _reals(2)
    mothers, fathers = space.random(2 * PAIRS, np.random.default_rng(8)).reshape(2, PAIRS, 2)
    whole, half = (
        SimulatedBinary(gene_probability=share)
        .cross(mothers, fathers, space, np.random.default_rng(6))
        .reshape(2, PAIRS, 2)
        for share in (1.0, 0.3)
    )
    kept = half[0] == mothers
    np.testing.assert_array_equal(half, np.where(kept, (mothers, fathers), whole))
    counts = np.bincount(2 * ~kept[:, 0] + ~kept[:, 1])
    assert stats.chisquare(counts, PAIRS * np.array([0.49, 0.21, 0.21, 0.09])).pvalue > 1e-3


@settings(max_examples=50)
@given(
    eta=st.floats(1, 100), genes=st.integers(1, 8), cyclic=st.booleans(), seed=st.integers(0, 2**32)
)
def test_simulated_binary_keeps_the_mean_of_parents(eta, genes, cyclic, seed):
    space = _reals(genes, lower=-3, upper=5, periodic=np.full(genes, cyclic))
    mothers, fathers = space.random(40, np.random.default_rng(seed)).reshape(2, 20, genes)
    crossover = SimulatedBinary(eta=eta)
    children = crossover.cross(mothers, fathers, space, np.random.default_rng(seed))
    # The mean of periodic genes may be that of the longer way round, half a period away.
    off = np.mod(children[:20] + children[20:] - mothers - fathers + 1, 8 if cyclic else np.inf)
    np.testing.assert_allclose(off, 1, atol=1e-6)


@pytest.mark.parametrize("crossover", [Blend(alpha=0), SimulatedBinary(eta=5)])
def test_periodic_genes_are_mixed_the_shorter_way_round(crossover):
    space = _reals(2, lower=-np.pi, upper=np.pi, periodic=np.array([True, False]))
    mothers, fathers = np.full((5000, 2), 3.0), np.full((5000, 2), -3.0)
    children = crossover.cross(mothers, fathers, space, np.random.default_rng(7))
    turn = np.abs(space.repair(children))
    # 3 and −3 rad are 0.28 apart through π, and 6 apart through 0.
    assert np.mean(turn[:, 0] > 2.7) > 0.99
    assert turn[:, 1].min() < 1
