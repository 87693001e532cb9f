"""A heat map of an archive, with a cursor on an elite."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from rich.style import Style
from textual import events
from textual.message import Message

from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.heat_map import HeatMap, Place, nearest, next_occupied, styles
from gaitsim.tui.keys import bindings
from gaitsim.tui.widgets.cells import Cells, Picture

_PARTS = ("axis", "empty", "pointer")


class ArchiveMap(Cells, can_focus=True):
    """One or two axes of an archive; arrow keys and clicks move the cursor between elites.

    Args:
        message: message shown without an elite.

    Attributes:
        view: view of the archive; None before the first.
        names: names of the one or two axes shown.
        labels: labels of the axes and the score, with units.
        marks: one-column characters shown on the cells of members, by number.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"map--axis", "map--empty", "map--pointer"}
    DEFAULT_CSS = """
    ArchiveMap {
        width: 1fr; height: 1fr;
        & > .map--axis { color: $foreground 80%; }
        & > .map--empty { color: $foreground 25%; }
        & > .map--pointer { color: #ff2d95; }
        &:light > .map--pointer { color: #d6006c; }
    }
    """
    BINDINGS = bindings("map cursor")

    @dataclass
    class CursorMoved(Message):
        """Posted with the number of the elite under the cursor, or None without elites."""

        member: int | None

    def __init__(self, message: str = "no gait yet", **settings: Any) -> None:
        super().__init__(**settings)
        self._message = message
        self.view: ArchiveView | None = None
        self.names: tuple[str, ...] = ()
        self.marks: Mapping[int, str] = {}
        self.labels: Mapping[str, str] = {}
        self._map: HeatMap | None = None
        self._drawn_at: tuple[int, int] | None = None
        self._place: Place | None = None
        self._values: tuple[float, ...] = ()  # position of the cursor on the axes
        self._wanted: int | None = None  # member on which to place the cursor

    def show(
        self,
        view: ArchiveView,
        names: tuple[str, ...],
        words: Mapping[str, str],
        member: int | None,
    ) -> None:
        """Show axes of an archive, with the cursor on a member.

        Args:
            view: view of the archive.
            names: names of one or two axes.
            words: labels of the axes and the score, with units.
            member: number of the member; None keeps the position, or moves to the best.
        """
        if member is None and (names != self.names or not self._values):
            member = view.best
        self.view, self.names, self.labels = view, names, words
        self._map = None
        self.go_to(member)

    def show_message(self, message: str) -> None:
        """Set the message that is shown until the archive has an elite."""
        self._message = message
        self.redraw()

    def go_to(self, member: int | None) -> None:
        """Move the cursor to the cell of a member; None keeps it in place."""
        self._wanted, self._place = member, None
        self._find()
        self.redraw()

    @property
    def member(self) -> int | None:
        """The number of the elite under the cursor."""
        found = self._map
        return None if found is None or self._place is None else int(found.numbers[self._place])

    def _find(self) -> HeatMap | None:
        """Return the map at the widget's size, after placing the cursor on an elite."""
        columns, rows = self.content_size
        if self.view is None or not columns or not rows:
            return None
        if self._map is None or self._drawn_at != (columns, rows):
            shaded = self.app.no_color
            self._map = HeatMap(self.view, self.names, self.labels, columns, rows, shaded=shaded)
            self._drawn_at, self._place = (columns, rows), None
        if self._place is None and (self._wanted or self._values):
            wanted = self._wanted
            near = self._map.place_of(wanted) if wanted else self._map.cell_of(*self._values)
            self._point(self._map, nearest(self._map.occupied, near))
        return self._map

    def _point(self, found: HeatMap, place: Place | None) -> None:
        """Place the cursor on a cell; None if all cells are empty."""
        self._place, self._wanted = place, None
        self._values = () if place is None else found.middle_of(place)
        self.post_message(self.CursorMoved(self.member))

    def placeholder(self) -> str:
        if self.view is None or not len(self.view.members.scores):
            return self._message
        found = self._find()
        return "" if found is not None and found.fits else "too narrow for a map"

    def picture(self, columns: int, rows: int) -> Picture:
        found = self._find()
        assert found is not None, "else the placeholder is shown"
        marks = {found.place_of(number): mark for number, mark in self.marks.items()}
        return found.draw(self._place, marks)

    def ink_styles(self) -> list[Style]:
        """Return the styles of axes, cursor, empty cells, and pairs of colours."""
        colours = [self.ink_style(f"map--{part}").color for part in _PARTS]
        names = [colour.name if colour is not None else "default" for colour in colours]
        if self.app.no_color:  # else the pointer would be dark grey
            names[_PARTS.index("pointer")] = names[_PARTS.index("axis")]
        return [self.ink_style() + Style.parse(style) for style in styles(*names)]

    def action_move(self, across: int, up: int) -> None:
        found = self._find()
        if found is not None and self._place is not None:
            self._go(found, next_occupied(found.occupied, self._place, across, up))

    def on_click(self, event: events.Click) -> None:
        found = self._find()
        place = None if found is None else found.cell_at(event.x, event.y)
        if found is not None and place is not None:
            self._go(found, nearest(found.occupied, place))

    def _go(self, found: HeatMap, place: Place | None) -> None:
        if place is not None and place != self._place:
            self._point(found, place)
            self.redraw()
