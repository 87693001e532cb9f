"""Curves in braille dots: the drawing, the axes and the widget."""

from contextlib import asynccontextmanager

import numpy as np
import pytest
from hypothesis import given, strategies as st
from textual.app import App
from waiting import strips

from gaitsim.render.series import Series
from gaitsim.render.terminal import curves
from gaitsim.render.terminal.curves import Scale, frame_of, plot, thin_series
from gaitsim.render.ticks import labels, ticks
from gaitsim.tui.widgets.cells import Cells
from gaitsim.tui.widgets.curves import CurvePlot, Curves


def series(y, name="best"):
    y = np.asarray(y, dtype=float)
    return Series(name, np.arange(1.0, len(y) + 1), y)


def lines(*drawn, columns=50, rows=12, **more):
    codes, _ = plot(drawn, columns, rows, **more)
    return ["".join(map(chr, row)) for row in codes]


def dots(row):
    return "".join(sign if "⠀" <= sign <= "⣿" else " " for sign in row)


class TestTicks:
    @given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.integers(1, 12))
    def test_ticks_are_round_few_and_on_the_axis(self, low, height, most):
        found = ticks(low, low + height, most)
        assert len(found) <= most + 1
        assert ((found >= low - 1e-3 * height) & (found <= low + 1.001 * height)).all()
        if len(found) > 2:
            assert np.allclose(np.diff(found), found[1] - found[0])

    def test_labels_have_equally_many_digits_and_true_minus_signs(self):
        assert labels(np.array([-1.0, 0.0, 0.5])) == ["−1.0", "0.0", "0.5"]
        assert labels(np.array([0.0, 20_000.0])) == ["0", "20,000"]
        assert labels(np.array([])) == []


class TestFrame:
    def test_it_includes_all_points(self):
        frame = frame_of([series([1, 3, 2]), series([0.5, np.nan, 4])])
        assert (frame.x, frame.y) == (Scale(1, 3), Scale(0.5, 4))

    def test_there_is_no_frame_without_finite_values(self):
        assert frame_of([series([np.nan, -np.inf]), series([])]) is None

    def test_a_constant_is_in_the_middle(self):
        frame = frame_of([series([3, 3, 3])])
        assert frame.y.low < 3 < frame.y.high

    def test_a_few_values_far_below_do_not_flatten_the_others(self):
        y = np.concatenate([[-1e6], np.linspace(1, 2, 99)])
        frame = frame_of([series(y)])
        assert frame.below
        assert frame.y.low >= 1
        assert any("↓" in line for line in lines(series(y)))


class TestPlot:
    def test_a_rise_goes_from_the_lower_left_to_the_upper_right(self):
        shown = lines(series(np.arange(100)))
        area = [dots(line[6:]) for line in shown[:-2]]
        assert area[-1][:6].strip()
        assert area[0][-6:].strip()
        assert not area[0][:6].strip()

    @pytest.mark.parametrize("hole", [np.nan, -np.inf, np.inf])
    def test_values_that_are_not_finite_leave_a_gap(self, hole):
        y = np.full(100, 1.0)
        y[40:60] = hole
        row = next(dots(line) for line in lines(series(y)) if dots(line).strip())
        left, gap, right = row.strip().partition("    ")
        assert left
        assert gap
        assert right.strip()

    def test_axes_have_numbers_and_labels(self):
        shown = lines(series(np.linspace(0, 2, 100)), x_label="generation")
        assert shown[-1].rstrip().endswith("generation")
        assert "50" in shown[-1]
        assert any(line.startswith(("1.0┤", " 1.0┤")) for line in shown)

    def test_stages_are_marked(self):
        _, inks = plot([series(np.arange(100))], 50, 12, marks=[50])
        _, without = plot([series(np.arange(100))], 50, 12)
        columns = np.flatnonzero((inks != without).any(axis=0))
        assert len(columns) == 1
        assert 20 < columns[0] < 30

    def test_each_series_has_an_ink_and_the_first_is_on_top(self):
        one, other = series([1, 1, 1]), series([1, 1, 1], "mean")
        _, inks = plot([one, other], 50, 12)
        found = np.bincount(inks.ravel())
        assert (
            found[curves.FIRST + 1] > 5 * found[curves.FIRST] > 0
        )  # only the markers of the other are visible

    @pytest.mark.parametrize("size", [(0, 0), (5, 2), (12, 4), (14, 5), (300, 80)])
    def test_any_size_can_be_drawn(self, size):
        columns, rows = size
        drawn = [series([1e9, -1e9, np.nan]), series([])]
        codes, inks = plot(drawn, columns, rows, "evaluations", [2])
        assert codes.shape == inks.shape == (rows, columns)

    @given(
        st.lists(st.floats(), max_size=20),
        st.booleans(),
        st.integers(1, 19),
    )
    def test_any_values_can_be_drawn(self, numbers, whole, stage):
        one = series(numbers)
        stages = (stage,) if stage < len(numbers) else ()
        other = Series("other", one.x, one.y[::-1], stages)
        plot([one, other], 40, 10, "generation", [3], 2.0, whole=whole)

    def test_a_run_far_below_is_shown_in_full(self):
        weak = Series("weak", np.arange(1.0, 21), np.linspace(-9, -8, 20))
        strong = series(np.linspace(1, 2, 1000), "strong")
        _, inks = plot([strong, weak], 60, 14, whole=True)
        assert (inks == curves.ink_of(1, 2)).any()
        _, inks = plot([strong, weak], 60, 14)
        assert not (inks == curves.ink_of(1, 2)).any()


class TestThinned:
    def test_peaks_are_preserved(self):
        y = np.zeros(100_000)
        y[[333, 77_777]] = 5, -7
        kept = thin_series(series(y), 100)
        assert len(kept.y) <= 1000
        assert (kept.y.max(), kept.y.min()) == (5, -7)
        assert kept.x[np.argmax(kept.y)] == pytest.approx(334, abs=250)

    def test_wide_gaps_are_preserved(self):
        y = np.ones(100_000)
        y[30_000:60_000] = -np.inf
        kept = thin_series(series(y), 100)
        inside = (kept.x > 31_000) & (kept.x < 59_000)
        assert np.isnan(kept.y[inside]).all()
        assert np.isfinite(kept.y[kept.x < 29_000]).all()


class Plot(App):
    def __init__(self):
        super().__init__()
        self.curves = Curves()

    def compose(self):
        yield self.curves


@asynccontextmanager
async def show(size=(50, 14)):
    app = Plot()
    async with app.run_test(size=size) as pilot:
        yield app.curves, pilot


class TestWidget:
    async def test_a_message_is_shown_without_finite_values(self):
        async with show() as (shown, pilot):
            assert "nothing to show yet" in picture_text(shown)
            shown.set_series([series([np.nan])], message="all failed")
            await pilot.pause()
            assert "all failed" in picture_text(shown)
            shown.set_series([series([1, 2])])
            await pilot.pause()
            assert "all failed" not in picture_text(shown)
            assert "┤" in picture_text(shown)

    async def test_the_legend_shows_names_literally(self):
        async with show() as (shown, pilot):
            shown.set_series([series([1, 2], "a [bold]x[/]"), series([2, 3], "漢字")])
            await pilot.pause()
            assert legend(shown) == "━●━ a [bold]x[/]  ╍◆╍ 漢字"
            assert len({shown.sample(index).style.color for index in range(2)}) == 2


def legend(shown):
    return str(shown.query_one(".legend").render())


class TestExploring:
    """The cursor, by keys and mouse."""

    @staticmethod
    async def fill(shown, pilot, y=None):
        y = np.linspace(1, 100, 100) if y is None else y
        shown.set_series([series(y)], [50], y_label="score")
        shown.focus()
        await pilot.pause()

    async def test_the_cursor_and_the_mouse_show_values(self):
        async with show(size=(50, 14)) as (shown, pilot):
            await self.fill(shown, pilot)
            await pilot.press("right")
            assert "generation 100" in legend(shown)
            await pilot.press("left", "shift+left")
            assert shown.cursor == 89
            assert "best 89" in legend(shown)
            await pilot.press("home", "left")
            assert shown.cursor == 1
            await pilot.press("end")
            assert shown.cursor == 100
            await pilot.hover(CurvePlot, offset=(40, 5))
            await pilot.pause()
            assert 60 < shown.cursor < 95
            assert shown.cursor in shown.series[0].x
            await pilot.click(CurvePlot, offset=(20, 5))
            await pilot.hover(".legend")
            await pilot.pause()
            assert 25 < shown.cursor < 45


def picture_text(shown):
    return "\n".join(strip.text for strip in strips(shown.query_one(Cells)))
