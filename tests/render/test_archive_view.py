"""Views of an archive along one or two axes."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.contracts import Members
from gaitsim.render.archive_view import EMPTY, ArchiveView

RNG = np.random.default_rng(0)


def view(axes: int, cells: int | tuple[int, ...], members: int) -> ArchiveView:
    """Return an archive with axes from 0 to 10; the values of a tessellation are near centroids."""
    names = [f"axis {number}" for number in range(axes)]
    if isinstance(cells, tuple):
        borders = [np.linspace(0, 10, count + 1) for count in cells]
        chosen = RNG.permutation(int(np.prod(cells)))[:members]
        found = np.stack(np.unravel_index(chosen, cells), 1).astype(np.int64)
        values = np.stack([b[found[:, i]] + 0.01 for i, b in enumerate(borders)], 1)
        centroids = None
    else:
        borders = [np.array([0.0, 10.0])] * axes
        centroids = RNG.uniform(0, 10, (cells, axes))
        found = RNG.permutation(cells)[:members, None].astype(np.int64)
        values = centroids[found[:, 0]]
    by_name = dict(zip(names, values.T, strict=True))
    scores = RNG.integers(0, 9, members).astype(float)  # with ties
    all_borders = dict(zip(names, borders, strict=True))
    genomes = np.zeros((members, 1))
    archive = ArchiveView.of(Members(genomes, scores, by_name, found, all_borders, centroids))
    assert archive is not None
    return archive


@pytest.mark.parametrize(("axes", "cells"), [(3, (4, 50, 7)), (8, 900)])
def test_panel_cells_hold_the_first_of_the_best_members(axes, cells):
    archive = view(axes, cells, 700)
    names = "axis 1", "axis 0"
    panel = archive.panel(*names, most=(20, 60))
    assert panel.scores.shape == tuple(len(borders) - 1 for borders in panel.borders)
    assert panel.scores.shape[0] <= 20
    places = [
        np.searchsorted(borders, archive.members.values[name], side="right") - 1
        for name, borders in zip(names, panel.borders, strict=True)
    ]
    for cell in np.ndindex(panel.scores.shape):
        within = np.flatnonzero((places[0] == cell[0]) & (places[1] == cell[1]))
        if len(within):
            best = within[np.argmax(archive.members.scores[within])]
            assert panel.members[cell] == best + 1
            assert panel.scores[cell] == archive.members.scores[best]
        else:
            assert panel.members[cell] == EMPTY
            assert np.isnan(panel.scores[cell])


def test_panel_of_a_two_axis_tessellation_shows_voronoi_cells():
    archive = view(2, 300, 200)
    panel = archive.panel(*archive.names)
    centroids = archive.members.centroids
    held = {int(cell): number for number, cell in enumerate(archive.cells[:, 0], start=1)}
    middles = [(one[:-1] + one[1:]) / 2 for one in panel.borders]
    for i, j in np.ndindex(panel.members.shape):
        away = np.hypot(*(centroids - [middles[0][i], middles[1][j]]).T)
        assert panel.members[i, j] == held.get(int(np.argmin(away)), EMPTY)


def test_pairs_begin_with_opposite_legs_even_in_an_empty_archive():
    archive = view(8, 50, 0)
    assert archive.pairs[:2] == (("axis 0", "axis 4"), ("axis 1", "axis 5"))
    assert len(set(archive.pairs)) == 28
    assert archive.best is None
    assert (archive.panel(*archive.pairs[0]).members == EMPTY).all()


def test_no_part_of_duty_factors_in_20_frame_strides_is_empty():
    members = view(8, 15_625, 400).members
    borders = {name: np.array([0.0, 0.7]) for name in members.values}
    values = {name: RNG.integers(0, 14, 400) / 20 for name in members.values}
    archive = ArchiveView.of(replace(members, values=values, borders=borders))
    assert archive is not None
    known = archive.panel("axis 0", "axis 4").members != EMPTY
    assert known.any(axis=0).all()
    assert known.any(axis=1).all()
