"""Interactive curves over generations, evaluations or seconds, in braille dots."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from rich.text import Text
from textual.app import ComposeResult
from textual.widget import Widget
from textual.widgets import Static

from gaitsim.render.series import Series
from gaitsim.render.terminal.curve_view import WINDOWS, CurveView, Scale, nearest
from gaitsim.render.terminal.curves import points_in_view
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.keys import bindings
from gaitsim.tui.widgets.curve_plot import CurvePlot

__all__ = ["CurveView", "Curves", "Series"]

STEP = 1.5  # zoom factor per key press or notch of the wheel
FEWEST = 4  # minimum visible points of the longest curve


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
        self._plot = CurvePlot(x_label, message, CurveView(whole=whole))
        self._legend = Static(classes="legend")
        self._legend_text: Text | None = None
        self._whole = whole
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
        """Replace the curves; keep the zoom if the axes show the same quantities.

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
            plot.view = plot.view.reset()
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
    def view(self) -> CurveView:
        """The visible part of the curves, and how they are shown."""
        return self._plot.view

    @view.setter
    def view(self, view: CurveView) -> None:
        self._plot.view = view
        self._redraw()

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

    def action_zoom(self, direction: int) -> None:
        self._zoom(direction, self.cursor)

    def action_pan(self, share: float) -> None:
        frame, whole = self._plot.frame, self._plot.whole_frame
        if frame is not None and whole is not None:
            self._show_x(frame.x.panned(share, whole.x))

    def action_reset(self) -> None:
        """Show the whole curves, the second time with single points far below the others."""
        self._cursor = self._hover = None
        whole = self._whole or not (self.view.zoomed or self.view.whole)
        self.view = replace(self.view.reset(), whole=whole)

    def action_smooth(self) -> None:
        at = WINDOWS.index(self.view.smooth)
        self.view = replace(self.view, smooth=WINDOWS[(at + 1) % len(WINDOWS)])

    def action_log(self) -> None:
        self.view = replace(self.view, log=not self.view.log)

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

    def action_end(self, last: int) -> None:
        whole = self._plot.whole_frame
        if whole is not None:
            self._point_at(whole.x.value(last))

    def _point_at(self, x: float) -> None:
        """Place the cursor on an x value, and move the view if necessary."""
        self._cursor, self._hover = x, None
        frame = self._plot.frame
        if frame is not None:
            share = float(frame.x.share(x))
            if not 0 <= share <= 1:
                self.action_pan(share - 1 if share > 1 else share)
        self._redraw()

    def _nearest_x(self, x: float) -> float:
        """Return the x value of the nearest point."""
        places = [float(one.x[at]) for one in self.series if (at := nearest(one, x)) is not None]
        return min(places, key=lambda place: abs(place - x), default=x)

    def _zoom(self, direction: int, x: float | None) -> None:
        frame, whole = self._plot.frame, self._plot.whole_frame
        if frame is None or whole is None:
            return
        most = max(len(one.x) for one in points_in_view(self._plot.smoothed, self.view))
        if direction > 0 and most <= FEWEST:
            return
        centre = 0.5 if x is None else float(frame.x.share(x))
        self._show_x(frame.x.zoomed(STEP**direction, centre if 0 <= centre <= 1 else 0.5, whole.x))

    def _show_x(self, ends: Scale | None) -> None:
        left, right = (ends.low, ends.high) if ends else (None, None)
        self.view = replace(self.view, left=left, right=right)

    def on_curve_plot_pointed(self, event: CurvePlot.Pointed) -> None:
        event.stop()
        x = None if event.x is None else self._nearest_x(event.x)
        if event.clicked:
            self._cursor = x
        if event.clicked or x != self._hover:
            self._hover = x
            self._redraw()

    def on_curve_plot_scrolled(self, event: CurvePlot.Scrolled) -> None:
        event.stop()
        self._hover = self._nearest_x(event.x)
        self._zoom(event.direction, event.x)


def legend(plot: CurvePlot, y_label: str, width: int) -> Text:
    """Return the legend of a plot, in as many rows as its names need at a width.

    The number of rows is the same with and without a cursor, so that the curves keep their size
    under the mouse. If names and values do not fit, only markers and values are shown.
    """
    if not plot.series:
        return Text()
    heads = [*([y_label] if y_label else []), *_describe_view(plot)]
    head = [Text(" · ".join(heads), "dim")] if heads else []
    names = [plot.sample(index).append(f" {visible(one.name)}")
             for index, one in enumerate(plot.series)]  # fmt: skip
    rows = _rows([*head, *names], width)
    if plot.cursor is not None:
        place = Text(f"{plot.x_label} {format_number(plot.cursor)}", "bold")
        values = [Text(f" {_value(one, plot.cursor)}", "bold") for one in plot.smoothed]
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


def _describe_view(plot: CurvePlot) -> Iterator[str]:
    """Yield descriptions of the smoothing, the zoom and the logarithmic axes."""
    view, frame = plot.view, plot.frame
    if view.smooth > 1:
        yield f"median of {view.smooth}"
    if view.zoomed:
        yield "zoomed"
    if frame is not None and view.log:
        yield "log scale" if frame.y.log else "no log scale: values ≤ 0"


def _rows(parts: list[Text], width: int) -> list[Text]:
    """Return the parts in rows."""
    rows = [Text()]
    for part in parts:
        if rows[-1] and rows[-1].cell_len + 2 + part.cell_len > width:
            rows.append(Text())
        rows[-1].append("  " if rows[-1] else "").append_text(part)
    return rows
