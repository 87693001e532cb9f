"""Curves over generations, evaluations or seconds, in braille dots, with a cursor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from rich.style import Style
from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from gaitsim.render.series import Series
from gaitsim.render.terminal import curves
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.keys import bindings
from gaitsim.tui.widgets.cells import Cells, Picture

__all__ = ["CurvePlot", "Curves", "Series"]

# Okabe & Ito (2008), as in plots; darker on a light background, for contrast.
DARK = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442", "#D55E00", "#FFFFFF")
LIGHT = ("#0072B2", "#B84F00", "#00785A", "#A34E82", "#7A6200", "#B3261E", "#1C242B")


class CurvePlot(Cells):
    """Curves in braille dots with axes and a cursor.

    Attributes:
        series: curves; the first is in front.
        marks: x values marked by dotted lines, such as starts of stages.
        x_label: label of the x axis.
        message: message shown without curves.
        whole: whether the y axis includes single points far below the others.
        cursor: x value of the cursor line; None for none.
    """

    @dataclass
    class Pointed(Message):
        """Posted when the mouse points at an x value or clicks it, or leaves (None)."""

        x: float | None
        clicked: bool = False

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "curves--axis",
        "curves--cursor",
        *(f"curves--{number}" for number in range(1, len(DARK) + 1)),
    }
    DEFAULT_CSS = """
    CurvePlot {
        width: 1fr; height: 1fr;
        & > .curves--axis { color: $foreground 60%; }
        & > .curves--cursor { color: $foreground; }
    """ + "".join(
        f"& > .curves--{number} {{ color: {dark}; }}\n"
        f"&:light > .curves--{number} {{ color: {light}; }}\n"
        for number, (dark, light) in enumerate(zip(DARK, LIGHT, strict=True), 1)
    ) + "}"  # fmt: skip

    def __init__(self, x_label: str, message: str = "", *, whole: bool = False) -> None:
        super().__init__()
        self.series: tuple[Series, ...] = ()
        self.marks: tuple[float, ...] = ()
        self.x_label, self.message, self.whole = x_label, message, whole
        self.cursor: float | None = None

    def placeholder(self) -> str:
        return "" if curves.frame_of(self.series) else self.message

    def picture(self, columns: int, rows: int) -> Picture:
        return curves.plot(
            self.series, columns, rows, self.x_label, self.marks, self.cursor, whole=self.whole
        )

    def ink_styles(self) -> list[Style]:
        """Return the styles of blank, axes, cursor, and the curves, last curve first."""
        return [
            self.ink_style(),
            self.ink_style("curves--axis"),
            self.ink_style("curves--cursor"),
            *(self.style_of(index) for index in reversed(range(len(self.series)))),
        ]

    def style_of(self, index: int) -> Style:
        """Return the style of a curve."""
        apart = self.series[index].incomparable
        return self.ink_style("curves--axis" if apart else f"curves--{index % len(DARK) + 1}")

    def sample(self, index: int) -> Text:
        """Return a sample of a curve for a legend."""
        plain = self.series[index].incomparable or len(self.series) == 1  # no marker
        piece = "───" if plain else curves.sample(index)
        return Text(piece, Style(color=self.style_of(index).color))

    def place(self, column: int) -> float | None:
        """Return the x value of the point nearest to a column."""
        area = curves.area_of(self.series, *self.content_size, whole=self.whole)
        if area is None:
            return None
        x = area.frame.x.value(area.share(column))
        places = [float(one.x[at]) for one in self.series if (at := nearest(one, x)) is not None]
        return min(places, key=lambda place: abs(place - x), default=x)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        self.post_message(self.Pointed(self.place(event.x)))

    def on_leave(self) -> None:
        self.post_message(self.Pointed(None))

    def on_click(self, event: events.Click) -> None:
        self.post_message(self.Pointed(self.place(event.x), clicked=True))


class Curves(Widget, can_focus=True):
    """Several curves with axes and a legend, redrawn only for new data.

    Curves differ in colour, dashes and markers. The first is drawn over the others. A cursor, or
    the mouse, shows the values at a point of the x axis.

    Args:
        x_label: label of the x axis.
        message: message shown without curves.
        whole: whether the y axis includes single points far below the others.
    """

    DEFAULT_CSS = """
    Curves {
        width: 1fr; height: 1fr; min-height: 3; layout: vertical;
        & > .legend { height: auto; min-height: 1; max-height: 4; }
        &:focus > CurvePlot > .curves--axis { color: $accent; }
    }
    """
    BINDINGS = bindings("curves")

    def __init__(
        self,
        x_label: str = "generation",
        message: str = "nothing to show yet",
        *,
        whole: bool = False,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        self._plot = CurvePlot(x_label, message, whole=whole)
        self._legend = Static(classes="legend")
        self._legend_text: Text | None = None
        self._y_label = ""
        self._cursor: float | None = None  # set by a key or a click
        self._hover: float | None = None  # under the mouse

    def compose(self) -> ComposeResult:
        yield self._legend
        yield self._plot

    def set_series(
        self,
        series: Sequence[Series],
        marks: Sequence[float] = (),
        *,
        x_label: str | None = None,
        y_label: str | None = None,
        message: str | None = None,
    ) -> None:
        """Replace the curves.

        Args:
            series: curves to show; without any, the message is shown.
            marks: x values to mark, such as starts of stages.
            x_label: label of the x axis; None keeps it.
            y_label: label of the y axis, at the start of the legend; None keeps it.
            message: message shown without curves; None keeps it.
        """
        plot = self._plot
        if len(series) != len(plot.series):
            plot.forget_styles()
        if x_label is not None and x_label != plot.x_label:
            plot.x_label, self._cursor, self._hover = x_label, None, None
        self._y_label = self._y_label if y_label is None else y_label
        plot.series, plot.marks = tuple(series), tuple(marks)
        plot.message = plot.message if message is None else message
        self._redraw()

    @property
    def series(self) -> tuple[Series, ...]:
        """The curves."""
        return self._plot.series

    @property
    def marks(self) -> tuple[float, ...]:
        """The marked x values."""
        return self._plot.marks

    @property
    def cursor(self) -> float | None:
        """The x value at which values are shown; None for none."""
        return self._cursor if self._hover is None else self._hover

    def sample(self, index: int) -> Text:
        """Return a sample of a curve for a legend."""
        return self._plot.sample(index)

    def _redraw(self) -> None:
        self._plot.cursor = self.cursor
        self._plot.redraw()
        self._explain()

    def _explain(self) -> None:
        """Update the legend if it has changed."""
        if not self.is_mounted:
            return
        text = legend(self._plot, self._y_label, self.content_size.width)
        before, self._legend_text = self._legend_text, text
        if before is None or text != before or text.spans != before.spans:
            higher = before is None or before.plain.count("\n") != text.plain.count("\n")
            self._legend.update(text, layout=higher)

    def on_resize(self) -> None:
        self._explain()

    def notify_style_update(self) -> None:
        super().notify_style_update()
        self.call_later(self._explain)

    def action_step(self, steps: int) -> None:
        """Move the cursor by points of the longest curve, starting at its end."""
        longest = max(self.series, key=lambda one: len(one.x), default=None)
        if longest is None or not len(longest.x):
            return
        place = len(longest.x) - 1
        if self._cursor is not None:
            within = min(max(self._cursor, longest.x[0]), longest.x[-1])
            place = min(max((nearest(longest, within) or 0) + steps, 0), place)
        self._point_at(float(longest.x[place]))

    def action_end(self, place: int) -> None:
        """Move the cursor to the first point of all curves (0) or the last one (−1)."""
        ends = [float(one.x[place]) for one in self.series if len(one.x)]
        if ends:
            self._point_at(max(ends) if place else min(ends))

    def _point_at(self, x: float) -> None:
        self._cursor, self._hover = x, None
        self._redraw()

    def on_curve_plot_pointed(self, event: CurvePlot.Pointed) -> None:
        event.stop()
        if event.clicked:
            self._cursor = event.x
        if event.clicked or event.x != self._hover:
            self._hover = event.x
            self._redraw()


def nearest(series: Series, x: float) -> int | None:
    """Return the index of the point nearest to x; None if x is outside the series."""
    if not len(series.x) or x < series.x[0] or x > series.x[-1]:
        return None
    return int(np.abs(series.x - x).argmin())


def legend(plot: CurvePlot, y_label: str, width: int) -> Text:
    """Return the legend of a plot, in as many rows as its names need at a width.

    The number of rows is the same with and without a cursor, so that the curves keep their size
    under the mouse. If names and values do not fit, only markers and values are shown.
    """
    if not plot.series:
        return Text()
    head = [Text(y_label, "dim")] if y_label else []
    names = [plot.sample(index).append(f" {visible(one.name)}")
             for index, one in enumerate(plot.series)]  # fmt: skip
    rows = _rows([*head, *names], width)
    if plot.cursor is not None:
        place = Text(f"{plot.x_label} {format_number(plot.cursor)}", "bold")
        values = [Text(f" {_value(one, plot.cursor)}", "bold") for one in plot.series]
        whole = [Text.assemble(*pair) for pair in zip(names, values, strict=True)]
        marks = [Text.assemble(plot.sample(index)[1:2], value)
                 for index, value in enumerate(values)]  # fmt: skip
        count = len(rows)
        for entries in ([*head, place, *whole], [place, *whole], [place, *marks]):
            rows = _rows(entries, width)
            if len(rows) <= count and all(row.cell_len <= width for row in rows):
                break
        rows = [*rows, *[Text()] * (count - len(rows))][:count]
    return Text("\n", no_wrap=True, overflow="ellipsis", end="").join(rows)


def _value(series: Series, x: float) -> str:
    place = nearest(series, x)
    return "–" if place is None else format_number(float(series.y[place]))


def format_number(value: float) -> str:
    """Return a number such as 12, 1.2346 or 1.235e−7; a dash if it is not finite."""
    if not math.isfinite(value):
        return "–"
    if value == round(value) and abs(value) < 1e9:
        return number(value, 0)
    return number(value, 4) if 1e-3 <= abs(value) < 1e6 else f"{value:.4g}".replace("-", "−")


def _rows(parts: list[Text], width: int) -> list[Text]:
    """Return the parts in rows."""
    rows = [Text()]
    for part in parts:
        if rows[-1] and rows[-1].cell_len + 2 + part.cell_len > width:
            rows.append(Text())
        rows[-1].append("  " if rows[-1] else "").append_text(part)
    return rows
