"""Each mutation: how many genes change, and by how much."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pydantic import ValidationError
from scipy import stats

from gaitsim.contracts import BitSpace, RealSpace
from gaitsim_operators.mutation import (
    BitFlip,
    Gaussian,
    NoMutation,
    Polynomial,
    RandomReplacement,
    Reset,
)

LOWER, UPPER = np.array([-1.0, 0.0, 10.0, -5.0]), np.array([1.0, 0.5, 30.0, 5.0])
WIDTH = UPPER - LOWER
LABELS = ("a", "b", "c", "d")
SPACE = RealSpace(LOWER, UPPER, LABELS)
MIDDLE = (LOWER + UPPER) / 2


def _bits(genes):
    return BitSpace(tuple(str(i) for i in range(genes)))


@pytest.mark.parametrize("rate", [0.0, 0.05, 0.4, 1.0])
@pytest.mark.parametrize("mutation", [Gaussian, Reset, Polynomial])
def test_each_gene_mutates_with_the_rate(mutation, rate):
    population = 20_000
    genomes = np.tile(LOWER + 0.3 * WIDTH, (population, 1))
    changed = mutation(rate=rate).mutate(genomes, SPACE, np.random.default_rng(1)) != genomes
    counts = np.bincount(changed.sum(axis=1), minlength=5)
    expected = stats.binom(4, rate).pmf(np.arange(5)) * population
    if rate in (0.0, 1.0):
        np.testing.assert_array_equal(counts, expected)
        return
    common = expected > 5
    assert counts[~common].sum() <= 5
    scaled = expected[common] / expected[common].sum() * counts[common].sum()
    assert stats.chisquare(counts[common], scaled).pvalue > 1e-3
    assert stats.chisquare(changed.sum(axis=0)).pvalue > 1e-3


def test_the_number_of_mutations_is_binomial():
    genomes = np.tile(MIDDLE, (25, 1))
    mutation = Gaussian(rate=0.1)
    counts = [
        (mutation.mutate(genomes, SPACE, np.random.default_rng(seed)) != genomes).sum()
        for seed in range(3000)
    ]
    binomial = stats.binom(100, 0.1)
    edges = np.arange(5, 17)
    observed = np.bincount(np.searchsorted(edges, counts), minlength=len(edges) + 1)
    chances = np.diff(np.concatenate(([0], binomial.cdf(edges), [1])))
    assert stats.chisquare(observed, chances * 3000).pvalue > 1e-3


@pytest.mark.parametrize("sigma", [0.01, 0.1, 2.0])
def test_gaussian_changes_are_normal_in_widths_of_the_gene(sigma):
    genomes = np.tile(MIDDLE, (5000, 1))
    mutants = Gaussian(rate=1, sigma=sigma).mutate(genomes, SPACE, np.random.default_rng(2))
    changes = (mutants - genomes) / (sigma * WIDTH)
    for gene in changes.T:
        assert stats.kstest(gene, stats.norm.cdf).pvalue > 1e-3


def test_gaussian_decays_from_generation_to_generation():
    assert Gaussian().at(500) == Gaussian()
    mutation = Gaussian(rate=1, sigma=0.2, decay=0.9)
    assert mutation.at(0) == mutation
    genomes = np.tile(MIDDLE, (20_000, 1))
    mutants = mutation.at(10).mutate(genomes, SPACE, np.random.default_rng(3))
    deviation = ((mutants - genomes) / WIDTH).std()
    # A standard deviation of n values is known to 1 part in √(2n): 0.25 % here.
    assert deviation == pytest.approx(0.2 * 0.9**10, rel=0.01)
    still = mutation.at(100_000).mutate(genomes, SPACE, np.random.default_rng(3))
    np.testing.assert_array_equal(still, genomes)


def test_options_out_of_bounds_are_refused():
    for options in ({"rate": -0.1}, {"rate": 1.1}, {"sigma": 0.0}, {"decay": 1.01}, {"decay": 0.0}):
        with pytest.raises(ValidationError):
            Gaussian(**options)


def test_reset_genes_are_distributed_as_in_the_space():
    spread = WIDTH / 20
    genomes = np.tile(LOWER, (5000, 1))
    for space, distribution in (
        (SPACE, lambda i: stats.uniform(LOWER[i], WIDTH[i])),
        (RealSpace(LOWER, UPPER, LABELS, spread), lambda i: stats.norm(MIDDLE[i], spread[i])),
    ):
        mutants = Reset(rate=0.5).mutate(genomes, space, np.random.default_rng(4))
        for i in range(4):
            fresh = mutants[mutants[:, i] != LOWER[i], i]
            assert 2300 < len(fresh) < 2700
            assert stats.kstest(fresh, distribution(i).cdf).pvalue > 1e-3


def test_reset_bits_are_fair():
    genomes = np.ones((2000, 10), dtype=np.uint8)
    mutants = Reset(rate=0.4).mutate(genomes, _bits(10), np.random.default_rng(5))
    assert stats.binomtest(int((mutants == 0).sum()), 20_000, 0.2).pvalue > 1e-3


def _steps(mutation, space, start, seed=6):
    genomes = np.tile(start, (5000, 1))
    mutants = mutation.mutate(genomes, space, np.random.default_rng(seed))
    return (mutants - genomes) / WIDTH


def _polynomial_cdf(step, eta, below, above):
    """Return the distribution function of a step, given the room on both sides, in widths."""
    power = eta + 1
    down = (np.maximum(1 + step, 0) ** power - (1 - below) ** power) / (1 - (1 - below) ** power)
    up = (np.maximum(1 - step, 0) ** power - (1 - above) ** power) / (1 - (1 - above) ** power)
    return np.where(step <= 0, 0.5 * np.clip(down, 0, 1), 1 - 0.5 * np.clip(up, 0, 1))


@pytest.mark.parametrize("eta", [0.0, 3.0, 20.0])
@pytest.mark.parametrize("below", [0.02, 0.3, 0.5, 0.95])
def test_polynomial_steps_follow_the_closed_form(eta, below):
    steps = _steps(Polynomial(rate=1, eta=eta), SPACE, LOWER + below * WIDTH)
    for gene in steps.T:
        assert gene.min() >= -below - 1e-9
        assert gene.max() <= 1 - below + 1e-9
        cdf = stats.kstest(gene, lambda step: _polynomial_cdf(step, eta, below, 1 - below))
        assert cdf.pvalue > 1e-3


def test_polynomial_steps_cross_the_bounds_of_periodic_genes():
    space = RealSpace(LOWER, UPPER, LABELS, periodic=np.array([True, False, True, False]))
    steps = _steps(Polynomial(rate=1, eta=2), space, LOWER + 0.1 * WIDTH)
    for i, room in enumerate([(1, 1), (0.1, 0.9), (1, 1), (0.1, 0.9)]):
        fit = stats.kstest(steps[:, i], lambda step, room=room: _polynomial_cdf(step, 2, *room))
        assert fit.pvalue > 1e-3


@pytest.mark.parametrize("beyond", [0.2, 1.5, 40.0])
def test_polynomial_brings_genes_outside_the_bounds_back(beyond):
    mutation = Polynomial(rate=1, eta=4)
    above = _steps(mutation, SPACE, UPPER + beyond * WIDTH)
    below = _steps(mutation, SPACE, LOWER - beyond * WIDTH)
    assert np.isfinite(above).all()
    assert np.isfinite(below).all()
    assert above.max() <= 1e-9
    assert below.min() >= -1e-9
    assert above.min() < -0.3
    assert below.max() > 0.3


@given(
    genes=st.integers(1, 30),
    count=st.integers(1, 40),
    population=st.integers(1, 20),
    seed=st.integers(0, 2**32),
)
def test_bit_flip_flips_the_given_number_of_different_bits(genes, count, population, seed):
    space = _bits(genes)
    genomes = space.random(population, np.random.default_rng(seed))
    mutants = BitFlip(count=count).mutate(genomes, space, np.random.default_rng(seed))
    assert ((mutants != genomes).sum(axis=1) == min(count, genes)).all()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_bit_flip_flips_all_bits_equally_often(count):
    genomes = np.zeros((20_000, 6), dtype=np.uint8)
    mutants = BitFlip(count=count).mutate(genomes, _bits(6), np.random.default_rng(7))
    flipped = dict.fromkeys(combinations(range(6), count), 0)
    for mutant in mutants:
        flipped[tuple(np.flatnonzero(mutant).tolist())] += 1
    assert stats.chisquare(list(flipped.values())).pvalue > 1e-3


@pytest.mark.parametrize("space", [SPACE, _bits(4)], ids=["real", "bit"])
def test_random_search_draws_fresh_genomes(space):
    genomes = space.random(30, np.random.default_rng(8))
    mutants = RandomReplacement().mutate(genomes, space, np.random.default_rng(9))
    np.testing.assert_array_equal(mutants, space.random(30, np.random.default_rng(9)))


@pytest.mark.parametrize("space", [SPACE, _bits(4)], ids=["real", "bit"])
def test_no_mutation_changes_nothing(space):
    genomes = space.random(30, np.random.default_rng(8))
    mutants = NoMutation().mutate(genomes, space, np.random.default_rng(9))
    np.testing.assert_array_equal(mutants, genomes)
    assert not np.shares_memory(mutants, genomes)
