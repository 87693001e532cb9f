"""Heat maps of archives in characters: colours, cells, and movement of the cursor."""

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex

from gaitsim.contracts import Members
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.braille import ink_runs
from gaitsim.render.terminal.heat_map import HeatMap, nearest, next_occupied
from gaitsim.render.terminal.member_picture import EMPTY, LEVELS, VIRIDIS, ColourScale, styles

WORDS = {"turn": "turn (°)", "stance": "stance 宽", "score": "score (m)"}


def archive(columns, rows, members=None):
    """Return an archive on a grid; the score of a member is the sum of its column and row."""
    cells = np.argwhere(np.ones((columns, rows), bool))
    if members is not None:
        cells = cells[np.random.default_rng(1).permutation(len(cells))[:members]]
    borders = {"turn": np.linspace(-90, 90, columns + 1), "stance": np.linspace(0, 1, rows + 1)}
    values = {
        name: (ends[at] + ends[at + 1]) / 2
        for (name, ends), at in zip(borders.items(), cells.T, strict=True)
    }
    scores = cells.sum(1).astype(float)
    view = ArchiveView.of(Members(np.zeros((len(cells), 2)), scores, values, cells, borders))
    assert view is not None
    return view


def test_levels_have_viridis_colours():
    known = matplotlib.colormaps["viridis"](np.linspace(0, 1, LEVELS))
    assert [to_hex(colour) for colour in known] == [*VIRIDIS]
    assert len(styles("red", "blue")) <= 256  # an ink is a byte
    scale = ColourScale.of(np.array([2.0, np.nan, 4.0]))
    assert scale.levels(np.array([2, 3, 4, np.nan, 1]), 4).tolist() == [1, 3, 4, 0, 1]


@pytest.mark.parametrize("shaded", [False, True])
@pytest.mark.parametrize(("columns", "rows"), [(3, 4), (33, 40), (7, 90), (200, 1)])
def test_cell_at_finds_each_cell_where_it_is_drawn(columns, rows, shaded):
    found = HeatMap(archive(columns, rows), ("turn", "stance"), WORDS, 60, 24, shaded=shaded)
    assert found.fits
    plain, before = found.draw()
    seen = set()
    for row, column in np.ndindex(24, 60):
        place = found.cell_at(column, row)
        if place is None:
            continue
        seen.add(place)
        if len(seen) % 7 == 0:
            codes, inks = found.draw(place)
            changed = np.argwhere((codes != plain) | (inks != before))
            assert abs(changed - (row, column)).max(1).min() <= 1
    assert {i for i, _ in seen} == set(range(found.numbers.shape[0]))
    assert len({j for _, j in seen}) >= found.numbers.shape[1] / (1 if shaded else 2)
    text = "".join(text for text, _ in ink_runs(plain[0], np.zeros(60, np.uint8)))
    assert "stance ?" in text


def test_empty_cells_are_dots_and_members_are_in_their_cells():
    view = archive(10, 10, members=30)
    found = HeatMap(view, ("turn", "stance"), WORDS, 50, 26)
    codes, inks = found.draw()
    assert (codes[inks == EMPTY] == ord("·")).all()
    assert (inks == EMPTY).any()
    for number in range(1, 31):
        assert found.place_of(number) == tuple(view.cells[number - 1])
        assert found.cell_of(*found.values_at(found.place_of(number))) == found.place_of(number)
    assert not HeatMap(view, ("turn", "stance"), WORDS, 12, 5).fits
    HeatMap(view, ("turn", "stance"), WORDS, 12, 5).draw((0, 0))


def test_cursor_skips_empty_cells_in_its_direction():
    occupied = np.zeros((9, 9), bool)
    for cell in [(0, 0), (4, 1), (6, 0), (1, 8), (3, 3)]:
        occupied[cell] = True
    assert next_occupied(occupied, (0, 0), 1, 0) == (4, 1)  # (3, 3) is nearer, but far off the line
    assert next_occupied(occupied, (4, 1), 1, 0) == (6, 0)
    assert next_occupied(occupied, (6, 0), 1, 0) == (6, 0)
    assert next_occupied(occupied, (3, 3), 0, 1) == (1, 8)
    assert next_occupied(occupied, (3, 3), 0, -1) == (4, 1)
    assert nearest(occupied, (8, 1)) == (6, 0)
    assert nearest(np.zeros((2, 2), bool), (0, 0)) is None
