"""The legend of curves: names, values at the cursor, and tools for the mouse."""

import math
from collections.abc import Iterator

from rich.style import Style
from rich.text import Text

from gaitsim.render.series import Series
from gaitsim.render.terminal.curve_view import nearest
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.widgets.curve_plot import CurvePlot

TOOL = "tool"  # key of a tool's action in the metadata of its style
TOOLS = (("+", "zoom(1)"), ("−", "zoom(-1)"), ("all", "reset"), ("log", "log_y"),
         ("smooth", "smooth"))  # fmt: skip
TOOLS_WIDTH = 60  # minimum columns of a legend with tools


def legend(plot: CurvePlot, y_label: str, width: int) -> Text:
    """Return the legend of a plot, in as many rows as its names need at a width.

    The number of rows is the same with and without a cursor, so that the curves keep their size
    under the mouse. If names and values do not fit, only markers and values are shown.
    """
    if not plot.series:
        return Text()
    heads = [*([y_label] if y_label else []), *_describe_view(plot)]
    head = [Text(" · ".join(heads), "dim")] if heads else []
    tools = Text()
    for name, action in TOOLS if width >= TOOLS_WIDTH else ():
        tools.append("  ").append(name, Style(underline=True, meta={TOOL: action}))
    names = [plot.sample(index).append(f" {visible(one.name)}")
             for index, one in enumerate(plot.series)]  # fmt: skip
    rows = _rows([*head, *names], tools, width)
    if plot.cursor is not None:
        place = Text(f"{plot.x_label} {format_number(plot.cursor)}", "bold")
        values = [Text(f" {_value(one, plot.cursor)}", "bold") for one in plot.smoothed]
        whole = [Text.assemble(*pair) for pair in zip(names, values, strict=True)]
        marks = [Text.assemble(plot.sample(index)[1:2], value)
                 for index, value in enumerate(values)]  # fmt: skip
        count = len(rows)
        for entries in ([*head, place, *whole], [place, *whole], [place, *marks]):
            rows = _rows(entries, tools, width)
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
    if frame is not None and view.log_y:
        yield "log scale" if frame.y.log else "no log scale: values ≤ 0"
    if frame is not None and view.log_x:
        yield f"log {plot.x_label}" if frame.x.log else f"no log {plot.x_label}: values ≤ 0"


def _rows(parts: list[Text], tools: Text, width: int) -> list[Text]:
    """Return the parts in rows, with the tools at the end of the first row."""
    rows = [Text()]
    for part in parts:
        room = width - (tools.cell_len if len(rows) == 1 else 0)
        if rows[-1] and rows[-1].cell_len + 2 + part.cell_len > room:
            rows.append(Text())
        rows[-1].append("  " if rows[-1] else "").append_text(part)
    if tools:
        rows[0].truncate(max(width - tools.cell_len, 1), overflow="ellipsis", pad=True)
        rows[0].append_text(tools)
    return rows
