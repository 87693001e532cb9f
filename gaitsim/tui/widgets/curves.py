"""Curves over generations or evaluations, in braille dots."""

from collections.abc import Sequence
from typing import Any, ClassVar

from rich.style import Style
from rich.text import Text
from textual.app import ComposeResult
from textual.widget import Widget

from gaitsim.render.terminal import curves
from gaitsim.render.terminal.curves import SAMPLES, Series
from gaitsim.tui.widgets.cells import Cells, Picture

__all__ = ["Curves", "Series"]

COLOURS = 6


class Curves(Widget):
    """Several curves with axes and a legend, redrawn only when there is new data.

    They differ by colour and by how they are dashed. The first is drawn over the others.

    Args:
        x_label: what the axis below shows.
        message: shown while there are no curves.
        legend: whether there is one.
    """

    DEFAULT_CSS = """
    Curves { width: 1fr; height: 1fr; min-height: 3; layout: vertical; }
    """

    def __init__(
        self,
        x_label: str = "generation",
        message: str = "nothing to show yet",
        *,
        legend: bool = True,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        self._plot = _Plot(x_label, message)
        self._legend = _Legend(self._plot) if legend else None

    def compose(self) -> ComposeResult:
        if self._legend is not None:
            yield self._legend
        yield self._plot

    def set_series(
        self,
        series: Sequence[Series],
        marks: Sequence[float] = (),
        *,
        x_label: str | None = None,
        message: str | None = None,
    ) -> None:
        """Show other curves.

        Args:
            series: to show; none of them shows the message.
            marks: where on the axis below something begins, such as a stage.
            x_label: what that axis shows; None as before.
            message: shown where there are no curves; None as before.
        """
        plot = self._plot
        if len(series) != len(plot.series):
            plot.forget_styles()
        plot.series, plot.marks = tuple(series), tuple(marks)
        plot.x_label = plot.x_label if x_label is None else x_label
        plot.message = plot.message if message is None else message
        plot.redraw()
        if self._legend is not None:
            self._legend.refresh()

    @property
    def series(self) -> tuple[Series, ...]:
        """The curves."""
        return self._plot.series

    @property
    def marks(self) -> tuple[float, ...]:
        """Places on the axis below where something begins."""
        return self._plot.marks

    def sample(self, index: int) -> Text:
        """Return a piece of a curve, as a legend shows it."""
        return self._plot.sample(index)


class _Legend(Widget):
    DEFAULT_CSS = "_Legend { height: 1; width: 1fr; }"

    def __init__(self, plot: "_Plot") -> None:
        super().__init__()
        self._plot = plot

    def render(self) -> Text:
        shown = Text(no_wrap=True, overflow="ellipsis", end="")
        for index, one in enumerate(self._plot.series):
            shown.append("  " if index else "")
            shown.append_text(self._plot.sample(index))
            shown.append(f" {one.name}")
        return shown


class _Plot(Cells):
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "curves--axis",
        *(f"curves--{number}" for number in range(1, COLOURS + 1)),
    }
    DEFAULT_CSS = """
    _Plot {
        width: 1fr; height: 1fr;
        & > .curves--axis { color: $foreground 60%; }
        & > .curves--1 { color: $primary; }
        & > .curves--2 { color: $warning; }
        & > .curves--3 { color: $success; }
        & > .curves--4 { color: $error; }
        & > .curves--5 { color: $foreground; }
        & > .curves--6 { color: $secondary; }
    }
    """

    def __init__(self, x_label: str, message: str) -> None:
        super().__init__()
        self.series: tuple[Series, ...] = ()
        self.marks: tuple[float, ...] = ()
        self.x_label, self.message = x_label, message

    def words(self) -> str:
        return "" if curves.frame_of(self.series) else self.message

    def picture(self, columns: int, rows: int) -> Picture:
        return curves.plot(self.series, columns, rows, self.x_label, self.marks)

    def ink_styles(self) -> list[Style]:
        """Return the styles of no ink, of the axes, and of the curves, the last one first."""
        return [
            self.ink_style(),
            self.ink_style("curves--axis"),
            *(self._style(index) for index in reversed(range(len(self.series)))),
        ]

    def sample(self, index: int) -> Text:
        return Text(SAMPLES[index % len(SAMPLES)], Style(color=self._style(index).color))

    def _style(self, index: int) -> Style:
        return self.ink_style(f"curves--{index % COLOURS + 1}")
