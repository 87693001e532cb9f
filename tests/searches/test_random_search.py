"""Random search draws genomes like the initial population, and keeps no state."""

import numpy as np
import pytest
from scipy import stats
from searching import box

from gaitsim.contracts import BitSpace
from gaitsim.contracts.search import Context
from gaitsim_searches.random_search import RandomSearch

SEARCH = RandomSearch()


def _asked(space, population, **parts):
    context = Context(space, population, 1, np.random.default_rng(1), **parts)
    return SEARCH.ask({}, None, context)[0]


def test_real_genes_are_uniform_or_normal_around_the_middle_as_the_space_defines():
    uniform = _asked(box(3), 5_000)
    around = _asked(box(3, initial_sigma=np.full(3, 1.0)), 5_000)

    for gene, other in zip(uniform.T, around.T, strict=True):
        assert stats.kstest(gene, stats.uniform(-5, 10).cdf).pvalue > 1e-3
        assert stats.kstest(other, stats.norm(0, 1).cdf).pvalue > 1e-3
    correlations = np.corrcoef(uniform.T)[np.triu_indices(3, 1)]
    np.testing.assert_allclose(correlations, 0, atol=0.05)


def test_bits_are_fair_and_repaired():
    space = BitSpace(tuple("abcd"), lambda bits: bits | np.uint8([0, 0, 0, 1]))
    genomes = _asked(space, 5_000)

    assert genomes.dtype == np.uint8
    np.testing.assert_allclose(genomes.mean(axis=0), [0.5, 0.5, 0.5, 1], atol=0.03)


@pytest.mark.parametrize("populations", [(), (3,)], ids=["one", "several"])
def test_a_warm_start_is_the_first_genome_of_the_first_generation(populations):
    start = np.array([1.0, 2.0])
    genomes = _asked(box(2), 5, starts=start[None], populations=populations)

    assert genomes.shape == (*populations, 5, 2)
    np.testing.assert_array_equal(genomes[..., 0, :], np.broadcast_to(start, (*populations, 2)))
    assert (genomes[..., 1:, :] != start).all()
