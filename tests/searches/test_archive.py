"""The archive of MAP-Elites, against loops over single candidates."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim_searches.archive import Archive, Candidates, Tessellation, even_centroids
from gaitsim_searches.emitters import SoftThresholds, improvement, with_soft_thresholds

CELLS = 6
SCORES = st.sampled_from([-2.0, -1.0, 0.0, 0.5, 1.0, 3.0, -np.inf])
BATCHES = st.lists(
    st.lists(st.tuples(st.integers(-1, CELLS - 1), SCORES), max_size=12), min_size=1, max_size=4
)


def _candidates(batch, first=0):
    """Return candidates whose only gene is their number, so that all genomes differ."""
    numbers = np.arange(first, first + len(batch), dtype=float)
    cells = np.array([cell for cell, _ in batch], np.int64)
    scores = np.array([score for _, score in batch])
    return Candidates(cells, numbers[:, None], scores, np.stack([numbers, -numbers], 1))


def _empty():
    return Archive.empty(np.empty((0, 1)), 2)


@given(BATCHES)
@settings(max_examples=60)
def test_inserting_a_batch_equals_inserting_its_candidates_one_by_one(batches):
    archive, elites, number = _empty(), {}, 0
    for batch in batches:
        archive = archive.inserted(_candidates(batch, number))
        for cell, score in batch:
            if cell >= 0 and score > elites.get(cell, (-np.inf, 0))[0]:
                elites[cell] = (score, number)
            number += 1
    assert archive.cells.tolist() == sorted(elites)
    assert archive.scores.tolist() == [elites[cell][0] for cell in sorted(elites)]
    numbers = np.array([elites[cell][1] for cell in sorted(elites)], float)
    np.testing.assert_array_equal(archive.genomes[:, 0], numbers)
    np.testing.assert_array_equal(archive.values, np.stack([numbers, -numbers], 1))
    np.testing.assert_array_equal(archive.thresholds, archive.scores)
    assert archive.is_consistent(CELLS, 2)


@given(BATCHES, st.sampled_from([0.0, 0.01, 0.3, 1.0]))
@settings(max_examples=60)
def test_thresholds_follow_the_batch_rule_of_cma_mae(batches, rate):
    soft = SoftThresholds(-1.5, rate)
    archive, thresholds = _empty(), dict.fromkeys(range(CELLS), soft.minimum)
    for batch in batches:
        candidates = _candidates(batch)
        found = improvement(archive, candidates, soft)
        for (cell, score), gain in zip(batch, found.gain, strict=True):
            valid = cell >= 0 and score > -np.inf
            expected = score - thresholds[cell] if valid else -np.inf
            assert gain == pytest.approx(expected, rel=0, abs=1e-12)
        archive = with_soft_thresholds(archive, archive.inserted(candidates), candidates, soft)
        for cell in range(CELLS):
            above = [score for at, score in batch if at == cell and score > thresholds[cell]]
            if above:
                kept = (1 - rate) ** len(above)
                thresholds[cell] = kept * thresholds[cell] + (1 - kept) * np.mean(above)
        expected = [thresholds[cell] for cell in archive.cells]
        np.testing.assert_allclose(archive.thresholds, expected, rtol=0, atol=1e-12)


def test_without_thresholds_discoveries_gain_their_score_and_others_the_difference():
    archive = _empty().inserted(_candidates([(1, 2.0), (3, -1.0)]))
    batch = _candidates([(1, 3.0), (1, 1.5), (3, 0.5), (0, -4.0), (0, -5.0), (-1, 9.0)])
    found = improvement(archive, batch, None)
    assert found.status.tolist() == [1, 0, 1, 2, 2, 0]
    assert found.gain.tolist() == [1.0, -0.5, 1.5, -4.0, -5.0, -np.inf]


def test_a_grid_has_evenly_spaced_borders_and_includes_points_outside_its_ranges():
    grid = Tessellation(np.array([[0.0, 1.0], [-30.0, 30.0]]), np.array([10, 3]), np.empty((0, 2)))
    points = np.array([[0, -30], [0.3, -10], [1, 30], [0.5, np.nan], [-9, 99], [0.2999, -10.001]])
    cells = grid.cells(points)
    assert grid.total == 30
    assert cells.tolist() == [0, 3 * 3 + 1, 29, -1, 2, 2 * 3]
    assert grid.indices(cells[[1, 2]]).tolist() == [[3, 1], [9, 2]]
    assert grid.cells(np.array([[np.inf, 0.0]])).tolist() == [-1]


@pytest.mark.parametrize("axes", [1, 3])
def test_a_point_belongs_to_the_nearest_centroid_in_shares_of_the_ranges(axes):
    rng = np.random.default_rng(axes)
    ranges = np.stack([rng.uniform(-50, 0, axes), rng.uniform(1, 1000, axes)], 1)
    centroids = rng.random((40, axes))
    cells = Tessellation(ranges, np.empty(0, np.int64), centroids)
    shares = rng.uniform(-0.2, 1.2, (200, axes))
    points = ranges[:, 0] + shares * (ranges[:, 1] - ranges[:, 0])
    distances = np.linalg.norm(np.clip(shares, 0, 1)[:, None] - centroids, axis=2)
    np.testing.assert_array_equal(cells.cells(points), distances.argmin(1))


@pytest.mark.parametrize(("cells", "axes"), [(4, 1), (1_024, 8), (1_000, 8)])
def test_centroids_are_evenly_distributed(cells, axes):
    # A digital net in base 2 has as many points in each of 2^k equal parts of an axis (Sobol 1967).
    found = even_centroids(cells, axes, np.random.default_rng(1))
    parts = 1 << (cells.bit_length() - 1)
    for axis in found.T:
        counts = np.bincount((axis * parts).astype(int), minlength=parts)
        assert counts.max() == -(-cells // parts)
