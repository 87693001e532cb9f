"""Pictures of the members of an archive or a front, with a cursor on a member."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Generic, Protocol, TypeVar

from rich.style import Style
from textual import events
from textual.message import Message

from gaitsim.contracts import Members
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.front_view import FrontView
from gaitsim.render.terminal.heat_map import HeatMap
from gaitsim.render.terminal.member_picture import (
    ON_DARK,
    ON_LIGHT,
    MemberPicture,
    Place,
    styles,
)
from gaitsim.render.terminal.scatter import Scatter
from gaitsim.tui.keys import bindings
from gaitsim.tui.widgets.cells import Cells, Picture

_PARTS = ("axis", "empty", "pointer")


class MemberView(Protocol):
    """Members of a run with axes along which to show them."""

    @property
    def members(self) -> Members: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def pairs(self) -> tuple[tuple[str, str], ...]: ...
    @property
    def best(self) -> int | None: ...


V = TypeVar("V", bound=MemberView)


class MemberPlot(Cells, Generic[V], can_focus=True):
    """Members along one or two axes; arrow keys and clicks move the cursor between them.

    Args:
        message: message shown until there is something to draw.

    Attributes:
        view: view of the members; None before the first.
        names: names of the one or two axes shown.
        labels: labels of the axes and the score, with units.
        marks: one-column characters shown on members, by number.
    """

    BINDINGS = bindings("map cursor")

    COMPONENT_CLASSES: ClassVar[set[str]] = {"members--axis", "members--empty", "members--pointer"}
    DEFAULT_CSS = """
    MemberPlot {
        width: 1fr; height: 1fr;
        & > .members--axis { color: $foreground 80%; }
        & > .members--empty { color: $foreground 25%; }
        & > .members--pointer { color: #ff2d95; }
        &:light > .members--pointer { color: #d6006c; }
    }
    """

    @dataclass
    class CursorMoved(Message):
        """Posted with the number of the member under the cursor, or None without members."""

        member: int | None

    def __init__(self, message: str) -> None:
        super().__init__()
        self.view: V | None = None
        self.names: tuple[str, ...] = ()
        self.marks: Mapping[int, str] = {}
        self.labels: Mapping[str, str] = {}
        self._message = message
        self._picture: MemberPicture | None = None
        self._drawn_at = (0, 0)
        self._place: Place | None = None
        self._values: tuple[float, ...] = ()  # position of the cursor on the axes
        self._wanted: int | None = None  # member on which to place the cursor

    @abstractmethod
    def picture_of(self, view: V, columns: int, rows: int) -> MemberPicture:
        """Return the picture of a view at a size."""

    def placeholder(self) -> str:
        found = self._find()
        if found is None:
            return self._message
        return "" if found.fits else "too narrow for these axes"

    def show_message(self, message: str) -> None:
        """Set the message that is shown until there is something to draw."""
        self._message = message
        self.redraw()

    def forget_styles(self) -> None:
        """Discard the styles and the picture, whose levels depend on the theme."""
        super().forget_styles()
        self._picture = None

    @property
    def levels(self) -> range:
        """The levels of points and lines that are visible on the background."""
        return ON_DARK if self.app.current_theme.dark else ON_LIGHT

    def ink_styles(self) -> list[Style]:
        """Return the styles of axes, cursor, empty cells, and pairs of colours."""
        colours = [self.ink_style(f"members--{part}").color for part in _PARTS]
        names = [colour.name if colour is not None else "default" for colour in colours]
        if self.app.no_color:  # else the pointer would be dark grey
            names[_PARTS.index("pointer")] = names[_PARTS.index("axis")]
        return [self.ink_style() + Style.parse(style) for style in styles(*names)]

    def show(
        self,
        view: V,
        names: tuple[str, ...],
        words: Mapping[str, str],
        member: int | None,
    ) -> None:
        """Show members along axes, with the cursor on one of them.

        Args:
            view: view of the members.
            names: names of one or two axes.
            words: labels of the axes and the score, with units.
            member: number of the member; None keeps the position, or moves to the best.
        """
        if member is None and (names != self.names or not self._values):
            member = view.best
        self.view, self.names, self.labels = view, names, words
        self._picture = None
        self.go_to(member)

    def go_to(self, member: int | None) -> None:
        """Move the cursor to the place of a member; None keeps it in place."""
        self._wanted, self._place = member, None
        self._find()
        self.redraw()

    @property
    def member(self) -> int | None:
        """The number of the member under the cursor."""
        found = self._picture
        return None if found is None or self._place is None else found.member(self._place)

    def _find(self) -> MemberPicture | None:
        """Return the picture at the widget's size, after placing the cursor on a member."""
        columns, rows = self.content_size
        if not columns or not rows:
            return None
        view, wanted = self.view, self._wanted
        if self._picture is None or self._drawn_at != (columns, rows):
            known = view is not None and len(view.members.scores)
            self._picture = self.picture_of(view, columns, rows) if view and known else None
            self._drawn_at, self._place = (columns, rows), None
        found = self._picture
        if found is not None and self._place is None and (wanted or self._values):
            self._point(
                found, found.place_of(wanted) if wanted else found.place_near(*self._values)
            )
        return found

    def _point(self, found: MemberPicture, place: Place | None) -> None:
        """Place the cursor; None if there are no members."""
        self._place, self._wanted = place, None
        self._values = () if place is None else found.values_at(place)
        self.post_message(self.CursorMoved(self.member))

    def picture(self, columns: int, rows: int) -> Picture:
        found = self._find()
        assert found is not None, "else the placeholder is shown"
        placed = ((found.place_of(number), mark) for number, mark in self.marks.items())
        marks = {place: mark for place, mark in placed if place is not None}
        return found.draw(self._place, marks)

    def action_move(self, across: int, up: int) -> None:
        found = self._find()
        if found is not None and self._place is not None:
            self._go(found, found.place_beside(self._place, across, up))

    def on_click(self, event: events.Click) -> None:
        found = self._find()
        if found is not None:
            self._go(found, found.place_at(event.x, event.y))

    def _go(self, found: MemberPicture, place: Place | None) -> None:
        if place is not None and place != self._place:
            self._point(found, place)
            self.redraw()


class ArchiveMap(MemberPlot[ArchiveView]):
    """One or two axes of an archive as a heat map."""

    def picture_of(self, view: ArchiveView, columns: int, rows: int) -> HeatMap:
        shaded = self.app.no_color
        return HeatMap(view, self.names, self.labels, columns, rows, shaded=shaded)


class FrontScatter(MemberPlot[FrontView]):
    """Two objectives of a front as a scatter plot.

    Attributes:
        colour: name of the objective that the colour shows; '' for none.
        others: whether to show the other individuals of the last generation.
    """

    DEFAULT_CSS = """
    FrontScatter > .members--empty { color: $foreground 45%; }
    """

    colour = ""
    others = True

    def picture_of(self, view: FrontView, columns: int, rows: int) -> Scatter:
        return Scatter(
            view,
            self.names,
            self.labels,
            columns,
            rows,
            colour=self.colour,
            others=self.others,
            levels=self.levels,
            shaded=self.app.no_color,
        )
