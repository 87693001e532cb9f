"""The plot of curves: drawing, colours and mouse events."""

from dataclasses import dataclass, replace
from typing import ClassVar

from rich.style import Style
from rich.text import Text
from textual import events
from textual.message import Message

from gaitsim.render.series import Series
from gaitsim.render.terminal import curves
from gaitsim.render.terminal.curve_view import CurveView, Frame, frame_of, smooth_series
from gaitsim.tui.widgets.cells import Cells, Picture

# Okabe & Ito (2008), as in plots; darker on a light background, for contrast.
DARK = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442", "#D55E00", "#FFFFFF")
LIGHT = ("#0072B2", "#B84F00", "#00785A", "#A34E82", "#7A6200", "#B3261E", "#1C242B")


class CurvePlot(Cells):
    """Curves in braille dots with axes and a cursor, which posts mouse events in x values.

    Attributes:
        series: curves; the first is in front.
        marks: x values marked by dotted lines, such as starts of stages.
        x_label: label of the x axis.
        message: message shown without curves.
        view: visible part of the curves, and how they are shown.
        cursor: x value of the cursor line; None for none.
    """

    @dataclass
    class Pointed(Message):
        """Posted when the mouse points at an x value or clicks it, or leaves (None)."""

        x: float | None
        clicked: bool = False

    @dataclass
    class Scrolled(Message):
        """Posted when the wheel turns forwards (1) or backwards (−1) at an x value."""

        x: float
        direction: int

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

    def __init__(self, x_label: str, message: str, view: CurveView) -> None:
        super().__init__()
        self.series: tuple[Series, ...] = ()
        self.marks: tuple[float, ...] = ()
        self.x_label, self.message, self.view = x_label, message, view
        self.cursor: float | None = None
        self._smoothed: tuple[tuple[tuple[Series, ...], int], list[Series]] = (((), 0), [])

    @property
    def smoothed(self) -> list[Series]:
        """The curves after smoothing."""
        key = self.series, self.view.smooth
        if key != self._smoothed[0]:
            self._smoothed = key, [smooth_series(one, self.view.smooth) for one in self.series]
        return self._smoothed[1]

    @property
    def frame(self) -> Frame | None:
        """The axes; None without curves."""
        return frame_of(self.smoothed, self.view)

    @property
    def whole_frame(self) -> Frame | None:
        """The axes that show all values, even scores far below the others."""
        return frame_of(self.smoothed, replace(self.view.reset(), whole=True))

    def placeholder(self) -> str:
        return "" if frame_of(self.series) else self.message

    def picture(self, columns: int, rows: int) -> Picture:
        view = replace(self.view, smooth=1)  # the curves are already smoothed
        return curves.plot(
            self.smoothed, columns, rows, self.x_label, self.marks, view, self.cursor
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
        """Return the x value of a column."""
        area = curves.area_of(self.smoothed, *self.content_size, self.view)
        return None if area is None else area.frame.x.value(area.share(column))

    def on_mouse_move(self, event: events.MouseMove) -> None:
        self.post_message(self.Pointed(self.place(event.x)))

    def on_leave(self) -> None:
        self.post_message(self.Pointed(None))

    def on_click(self, event: events.Click) -> None:
        self.post_message(self.Pointed(self.place(event.x), clicked=True))

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self._scrolled(event, 1)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self._scrolled(event, -1)

    def _scrolled(self, event: events.MouseEvent, direction: int) -> None:
        x = self.place(event.x)
        if x is not None:
            event.stop()
            event.prevent_default()
            self.post_message(self.Scrolled(x, direction))
