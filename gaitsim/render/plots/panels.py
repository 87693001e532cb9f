"""Small panels in rows and columns with a common time axis."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.plots.style import Theme

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BAR = 0.72  # height of a bar, relative to its row
_HEADROOM = 0.75  # space above and below the panels, inches


def grid(
    count: int,
    width: float,
    *,
    columns: int = 1,
    height: float = 1.0,
    downwards: bool = False,
    share_y: bool = False,
) -> tuple["Figure", list["Axes"]]:
    """Create a figure with panels; the panels of a column share their x axis.

    Args:
        count: number of panels.
        width: width of the figure, inches.
        columns: number of columns.
        height: height of a panel, inches.
        downwards: whether to fill column by column rather than row by row.
        share_y: whether all panels share their y axis.
    """
    from matplotlib.figure import Figure

    rows = -(-count // columns)
    figure = Figure(figsize=(width, _HEADROOM + rows * height))
    places = figure.subplots(rows, columns, sharex=True, sharey=share_y, squeeze=False)
    ordered = [*(places.T if downwards else places).ravel()]
    for unused in ordered[count:]:
        unused.remove()
    for column in places.T:
        below = [axes for axes in column if axes in figure.axes]
        if below:  # the lowest panel of a short column also has numbers
            below[-1].tick_params(labelbottom=True)
    return figure, ordered[:count]


def rows_of_panels(
    figure: "Figure", count: int, columns: int, *, share_y: bool = False
) -> list["Axes"]:
    """Create panels in rows, of which the last may be shorter."""
    rows = -(-count // columns)
    places = [*figure.subplots(rows, columns, sharey=share_y, squeeze=False).ravel()]
    for unused in places[count:]:
        unused.remove()
    return places[:count]


def draw_bars(
    axes: "Axes",
    rows: Sequence[tuple[str, NDArray[np.bool_]]],
    start: float,
    rate: float,
    colours: Sequence[str],
    alpha: float = 1.0,
) -> None:
    """Draw a row of bars for each series of truth values, with the first row at the top.

    Args:
        axes: axes to draw in.
        rows: names and truth values, (frames,), of the rows.
        start: time of the first frame, s.
        rate: frames per second, Hz; a frame lasts until the next one.
        colours: colour of each row.
        alpha: opacity of the bars.
    """
    for place, ((_, holds), colour) in enumerate(zip(rows, colours, strict=True)):
        spans = intervals(holds, start, rate)
        axes.broken_barh(spans, (place - BAR / 2, BAR), facecolor=colour, alpha=alpha, linewidth=0)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(start, start + len(rows[0][1]) / rate)


def limit_time(axes: "Axes", part: slice, rate: float) -> None:
    """Limit a time axis to a part of the frames.

    The axis ends at the last frame or one frame later, whichever is the rounder number, so that
    300 frames at 30 Hz, of which the last begins at 9.97 s, end at the label 10.
    """
    ends = ((part.stop - 1) / rate, part.stop / rate)
    axes.set_xlim(part.start / rate, min(ends, key=lambda end: len(f"{end:.6g}")))


def intervals(holds: NDArray[np.bool_], start: float, rate: float) -> list[tuple[float, float]]:
    """Return starts and durations of true intervals, s; a frame lasts until the next one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], holds, [False]]).astype(np.int8)))
    begins, ends = edges[::2], edges[1::2]
    return [
        (start + begin / rate, (end - begin) / rate)
        for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)
    ]


def shade_spans(
    axes: "Axes", spans: Sequence[tuple[float, float]], theme: Theme, **more: Any
) -> None:
    """Shade spans of time, as starts and durations, in the background."""
    low_high = axes.get_xaxis_transform()
    axes.broken_barh(
        spans, (0, 1), transform=low_high, facecolor=theme.faint, alpha=0.5, zorder=0, **more
    )
