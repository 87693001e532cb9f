"""Scatter plots of fronts in characters: points, directions, and movement of the cursor."""

import numpy as np
import pytest

from gaitsim.contracts import Members
from gaitsim.render.front_view import FrontView
from gaitsim.render.terminal.member_picture import (
    MARKED,
    NONE,
    ON_ANY,
    ON_DARK,
    ON_LIGHT,
    ink_of,
)
from gaitsim.render.terminal.scatter import Scatter

WORDS = {"speed": "speed (m/s)", "cost": "cost 宽 (J)", "calm": "calm", "score": "score"}
SIZE = 60, 24


def front(*rows, others=None, names=("speed", "cost", "calm")):
    """Return a front from the values of its members, one row each."""
    values = dict(zip(names, np.array(rows, float).T, strict=False))
    scores = np.arange(len(rows), dtype=float)
    directions = {name: "min" if name == "cost" else "max" for name in values}
    behind = {} if others is None else dict(zip(names, np.array(others, float).T, strict=False))
    return FrontView(Members(np.zeros((len(rows), 1)), scores, values), directions, behind)


def drawn(scatter, *arguments):
    codes, inks = scatter.draw(*arguments)
    return ["".join(map(chr, row)) for row in codes], inks


def curved(count):
    across = np.linspace(0, 1, count)
    return front(*np.stack([across, np.sqrt(across), 1 - across], axis=1))


def test_points_are_where_the_axes_say_and_arrows_point_to_better_values():
    scatter = Scatter(front((0, 10), (1, 20), (4, 50)), ("speed", "cost"), WORDS, *SIZE)
    text, _ = drawn(scatter, (1,))
    assert "speed (m/s), better →" in text[-2]
    assert "cost ? (J), better ↓" in text[0]
    row = next(at for at, line in enumerate(text) if "◆" in line)
    column = text[row].index("◆")
    # Member 2 is a quarter along both axes.
    (x_low, x_high), (y_low, y_high) = scatter.area.ends
    wide, high = SIZE[0] - scatter.area.left - 1, scatter.area.height
    assert column == pytest.approx(scatter.area.left + (1 - x_low) / (x_high - x_low) * wide, abs=1)
    assert row == pytest.approx(high - (20 - y_low) / (y_high - y_low) * high + 0.5, abs=1)
    assert text[row][scatter.area.left - 1] == "▸"


@pytest.mark.parametrize("count", [2, 40, 5_000])
def test_every_member_of_a_front_is_reached_and_clicks_find_the_nearest(count):
    scatter = Scatter(curved(count), ("speed", "cost"), WORDS, *SIZE)
    place, met = (0,), set()
    while place not in met:
        met.add(place)
        before = place
        place = scatter.place_beside(place, 1, 0)
        place = scatter.place_beside(place, 0, 1) if place == before else place
    dots = {tuple(dot) for dot in scatter._dots.tolist()}
    assert scatter.values_at(place)[0] == pytest.approx(1, abs=0.03)
    assert len(met) >= 0.3 * len(dots)
    for number in (1, count // 2, count):
        row, column = scatter._cell(scatter.place_of(number))
        found = scatter.place_at(column, row)
        assert np.abs(np.subtract(scatter._cell(found), (row, column))).max() <= 1
    assert scatter.place_at(0, 0) is None


def test_the_colour_is_another_objective_and_others_are_behind():
    view = front(*np.random.default_rng(1).random((30, 3)), others=[(0.5, 0.5, 0.5)] * 3)
    plain = Scatter(view, ("speed", "cost"), WORDS, *SIZE)
    coloured = Scatter(view, ("speed", "cost"), WORDS, *SIZE, colour="calm")
    assert len(np.unique(drawn(coloured)[1])) > len(np.unique(drawn(plain)[1])) + 3
    assert "calm" in drawn(coloured)[0][-1]
    assert "last generation" in drawn(plain)[0][-1]
    assert (
        "last generation"
        not in drawn(Scatter(view, ("speed", "cost"), WORDS, *SIZE, others=False))[0][-1]
    )


@pytest.mark.parametrize(
    "rows",
    [
        [(1.0, 2.0)],
        [(3.0, 3.0)] * 5,
        [(1e308, -1e308), (-1e308, 1e308)],
        [(0.0, 1e-320), (1e-320, 0.0)],
    ],
)
@pytest.mark.parametrize("shaded", [False, True])
def test_extreme_fronts_are_drawn(rows, shaded):
    scatter = Scatter(front(*rows), ("speed", "cost"), WORDS, *SIZE, shaded=shaded)
    text, _ = drawn(scatter, scatter.place_of(1))
    assert any("◆" in line for line in text)


def test_members_without_a_value_are_counted_and_skipped():
    nan = np.nan
    view = front((0, 1), (nan, 2), (2, nan), (3, np.inf), (4, 5))
    scatter = Scatter(view, ("speed", "cost"), WORDS, *SIZE)
    assert "3 without values" in drawn(scatter, (0,))[0][-1]
    assert scatter.place_beside((0,), 1, 0) == (4,)
    assert scatter.place_of(2) == (0,)
    none = Scatter(front((nan, nan)), ("speed", "cost"), WORDS, *SIZE)
    assert none.place_of(1) is none.place_near(0.0, 0.0) is none.place_at(30, 10) is None
    drawn(none)


def test_colours_are_visible_on_the_background():
    view = front(*np.random.default_rng(1).random((30, 3)))
    for levels in (ON_DARK, ON_LIGHT, ON_ANY):
        scatter = Scatter(view, ("speed", "cost"), WORDS, *SIZE, colour="calm", levels=levels)
        inks = np.unique(drawn(scatter)[1])
        points = {ink_of(level, NONE) for level in levels}
        assert {int(ink) for ink in inks if ink_of(1, NONE) <= ink < MARKED} - points <= {
            ink_of(level, level) for level in levels
        }
        assert len(points & {*inks.tolist()}) > 3
