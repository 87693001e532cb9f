"""The emitters of CMA-ME and CMA-MAE: closed forms, ranking and restarts."""

import numpy as np
import pytest

from gaitsim.contracts import RealSpace
from gaitsim_searches.emitters import Emitters, Improvement, adapt_emitters, draw_genomes

GENES = 6
SPACE = RealSpace(np.full(GENES, -2.0), np.full(GENES, 8.0), tuple("abcdef"))


def _emitters(count, step=0.1):
    return Emitters.create(np.full((count, GENES), 3.0), step)


def _found(gain, status=None):
    gain = np.asarray(gain, float)
    return Improvement(np.ones(len(gain), np.int64) if status is None else np.array(status), gain)


def _one_step_by_the_tutorial(emitter, genomes, parents):
    """Adapt one emitter as in Hansen 2016, "The CMA evolution strategy: a tutorial".

    Only positive weights are used.
    """
    mu, n = parents, GENES
    weights = np.log(mu + 0.5) - np.log(np.arange(1, mu + 1))
    weights /= weights.sum()
    mass = 1 / (weights**2).sum()
    c_sigma = (mass + 2) / (n + mass + 5)
    d_sigma = 1 + 2 * max(0, np.sqrt((mass - 1) / (n + 1)) - 1) + c_sigma
    c_c = (4 + mass / n) / (n + 4 + 2 * mass / n)
    c_1 = 2 / ((n + 1.3) ** 2 + mass)
    c_mu = min(1 - c_1, 2 * (mass - 2 + 1 / mass) / ((n + 2) ** 2 + mass))
    steps = (genomes[:mu] - emitter.mean[0]) / SPACE.width / emitter.step[0]
    shift = weights @ steps
    root = emitter.basis[0] @ np.diag(1 / emitter.lengths[0]) @ emitter.basis[0].T
    conjugate = (1 - c_sigma) * emitter.conjugate[0]
    conjugate = conjugate + np.sqrt(c_sigma * (2 - c_sigma) * mass) * root @ shift
    age = emitter.age[0] + 1
    length = conjugate @ conjugate / n
    rising = length / (1 - (1 - c_sigma) ** (2 * age)) < 2 + 4 / (n + 1)
    path = (1 - c_c) * emitter.path[0] + rising * np.sqrt(c_c * (2 - c_c) * mass) * shift
    covariance = (1 - c_1 - c_mu) * emitter.covariance[0] + c_1 * np.outer(path, path)
    covariance += c_1 * (not rising) * c_c * (2 - c_c) * emitter.covariance[0]
    for weight, step in zip(weights, steps, strict=True):
        covariance += c_mu * weight * np.outer(step, step)
    sigma = emitter.step[0] * np.exp(min(1, c_sigma / d_sigma * (length - 1) / 2))
    mean = emitter.mean[0] + shift * emitter.step[0] * SPACE.width
    return {"mean": mean, "step": sigma, "covariance": covariance, "path": path}


@pytest.mark.parametrize("parents", [1, 4, 9])
def test_an_emitter_follows_the_tutorial(parents):
    emitters, rng = _emitters(1), np.random.default_rng(parents)
    for _ in range(12):
        genomes = draw_genomes(emitters, 9, SPACE, rng)
        gain = np.sort(rng.random(9))[::-1]
        expected = _one_step_by_the_tutorial(emitters, genomes, parents)
        status = (np.arange(9) < parents).astype(np.int64)
        emitters, _ = adapt_emitters(
            emitters, genomes, _found(gain, status), SPACE, two_stages=True
        )
        for name, value in expected.items():
            np.testing.assert_allclose(getattr(emitters, name)[0], value, rtol=1e-10, atol=1e-14)
        decomposed = (emitters.basis[0] * emitters.lengths[0] ** 2) @ emitters.basis[0].T
        if emitters.decomposed[0] == emitters.age[0]:
            np.testing.assert_allclose(decomposed, emitters.covariance[0], rtol=1e-10, atol=1e-14)
    assert emitters.decomposed[0] > 0


def test_discoveries_rank_before_improvements_and_only_inserted_genomes_are_parents():
    genomes = 3.0 + np.arange(5)[:, None] * np.ones(GENES) * 0.1
    found = _found([5.0, 9.0, 1.0, -2.0, 0.5], [2, 1, 2, 0, 0])
    climbing, _ = adapt_emitters(_emitters(1), genomes, found, SPACE, two_stages=True)
    weights = np.log(3.5) - np.log([1, 2, 3])
    expected = weights @ genomes[[0, 2, 1], 0] / weights.sum()
    np.testing.assert_allclose(climbing.mean[0], expected)
    by_gain, _ = adapt_emitters(_emitters(1), genomes, found, SPACE, two_stages=False)
    weights = np.log(2.5) - np.log([1, 2])
    np.testing.assert_allclose(by_gain.mean[0], weights @ genomes[[1, 0], 0] / weights.sum())


@pytest.mark.parametrize("population", [6, 7, 8])
def test_each_emitter_learns_from_its_own_genomes_in_any_population(population):
    emitters = Emitters.create(np.array([np.full(GENES, 0.0), np.full(GENES, 5.0)]), 0.001)
    genomes = draw_genomes(emitters, population, SPACE, np.random.default_rng(1))
    assert genomes.shape == (population, GENES)
    np.testing.assert_array_equal(genomes[:, 0] > 2.5, np.arange(population) % 2 == 1)
    gain = np.random.default_rng(2).random(population)
    learnt, ended = adapt_emitters(emitters, genomes, _found(gain), SPACE, two_stages=False)
    assert not ended.any()
    for emitter in range(2):
        own, alone = genomes[emitter::2], only_one(emitters, emitter)
        expected, _ = adapt_emitters(alone, own, _found(gain[emitter::2]), SPACE, two_stages=False)
        np.testing.assert_allclose(learnt.mean[emitter], expected.mean[0], rtol=1e-12)
        np.testing.assert_allclose(learnt.step[emitter], expected.step[0], rtol=1e-12)


def only_one(emitters, which):
    return Emitters.create(emitters.mean[[which]], 0.001)


def test_emitters_without_improvement_or_with_equal_gains_or_tiny_steps_end():
    genomes = draw_genomes(_emitters(4), 16, SPACE, np.random.default_rng(1))
    gain = np.random.default_rng(2).random((4, 4))
    status = np.ones((4, 4), np.int64)
    status[:, 1] = 0
    gain[:, 2] = 0.25
    gain[0, 3] = -np.inf  # a single failed individual does not end an emitter
    found = _found(gain.ravel(), status.ravel())
    _, ended = adapt_emitters(_emitters(4), genomes, found, SPACE, two_stages=True)
    assert ended.tolist() == [False, True, True, False]
    _, ended = adapt_emitters(_emitters(4), genomes, found, SPACE, two_stages=False)
    assert ended.tolist() == [False, False, True, False]
    _, ended = adapt_emitters(_emitters(4, 1e-12), genomes, found, SPACE, two_stages=False)
    assert ended.all()
    none = _found(np.full(16, -np.inf), np.zeros(16, np.int64))
    for two_stages in (True, False):
        _, ended = adapt_emitters(_emitters(4), genomes, none, SPACE, two_stages=two_stages)
        assert ended.all()


def test_an_emitter_crosses_the_bound_of_a_periodic_gene():
    periodic = np.arange(GENES) == 0
    space = RealSpace(SPACE.lower, SPACE.upper, SPACE.labels, periodic=periodic)
    emitters = Emitters.create(np.full((1, GENES), 7.9), 0.01)
    genomes = np.full((4, GENES), 7.9)
    genomes[:, 0] = -1.9  # 0.2 from the mean across the bound
    learnt, _ = adapt_emitters(emitters, genomes, _found([4, 3, 2, 1]), space, two_stages=False)
    np.testing.assert_allclose(space.repair(learnt.mean)[0], genomes[0], atol=1e-12)
