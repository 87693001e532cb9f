"""Portable linear algebra against NumPy and SciPy."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.linalg import solve_triangular
from scipy.spatial.distance import cdist
from scipy.stats import ortho_group

from gaitsim import portable


def positive_definite(rng, *shape):
    factors = rng.normal(size=shape)
    return factors @ factors.swapaxes(-1, -2) + np.eye(shape[-1])


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((3, 4), (4, 5)),
        ((1, 4), (4, 1)),
        ((6, 3, 4), (4, 2)),
        ((2, 1, 3, 4), (5, 4, 2)),
        ((0, 3), (3, 2)),
    ],
)
def test_products_of_matrices(one, other):
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=one), rng.normal(size=other)
    np.testing.assert_allclose(portable.matmul(a, b), a @ b, rtol=1e-12, atol=1e-14)
    transposed = b.swapaxes(-1, -2).copy().swapaxes(-1, -2)
    np.testing.assert_array_equal(portable.matmul(a, transposed), portable.matmul(a, b))


def test_products_are_summed_in_order():
    a, b = np.array([[1e16, 1.0, -1e16]]), np.ones((3, 1))
    assert portable.matmul(a, b) == 0.0


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"\(2, 3\) and \(2, 3\)"):
        portable.matmul(np.ones((2, 3)), np.ones((2, 3)))


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 12), st.integers(0, 1000))
def test_positive_definite_systems(size, seed):
    rng = np.random.default_rng(seed)
    matrices, vectors = positive_definite(rng, 4, size, size), rng.normal(size=(4, size))
    expected = np.linalg.solve(matrices, vectors[..., None])[..., 0]
    np.testing.assert_allclose(portable.solve(matrices, vectors), expected, rtol=1e-8, atol=1e-10)
    lower = portable.cholesky(matrices[0])
    np.testing.assert_allclose(lower, np.linalg.cholesky(matrices[0]), rtol=1e-10, atol=1e-12)
    right = rng.normal(size=(size, 3))
    np.testing.assert_allclose(
        portable.solve_triangular(lower, right),
        solve_triangular(lower, right, lower=True),
        rtol=1e-8,
        atol=1e-10,
    )


def test_a_matrix_that_is_not_positive_definite_gives_nan():
    assert np.isnan(portable.cholesky(-np.eye(2))).any()
    assert np.isnan(portable.solve(-np.eye(2), np.ones(2))).any()


@pytest.mark.parametrize("genes", [1, 2, 10, 48])
def test_principal_axes(genes):
    covariance = positive_definite(np.random.default_rng(genes), genes, genes)
    variances, axes = portable.principal_axes(covariance)
    np.testing.assert_allclose(np.sort(variances), np.linalg.eigvalsh(covariance), rtol=1e-10)
    np.testing.assert_allclose(axes @ axes.T, np.eye(genes), atol=1e-12)
    np.testing.assert_allclose(axes.T * variances @ axes, covariance, rtol=1e-9, atol=1e-9)


def test_principal_axes_of_a_graded_matrix():
    rotation = ortho_group.rvs(12, random_state=0)
    covariance = (rotation * np.logspace(0, 8, 12)) @ rotation.T
    variances, axes = portable.principal_axes((covariance + covariance.T) / 2)
    np.testing.assert_allclose(np.sort(variances), np.logspace(0, 8, 12), rtol=1e-7)
    np.testing.assert_allclose(axes.T * variances @ axes, covariance, atol=1e-6)


def test_distances_and_norms():
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(5, 3)), rng.normal(size=(7, 3))
    np.testing.assert_allclose(portable.distances(one, other), cdist(one, other), rtol=1e-14)
    np.testing.assert_allclose(portable.norm(one), np.linalg.norm(one, axis=-1), rtol=1e-15)
