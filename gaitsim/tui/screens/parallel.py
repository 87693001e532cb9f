"""Parallel coordinates of the members of a run or of the cells of a study."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual import events, on, work
from textual.app import ComposeResult
from textual.message import Message

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which
from gaitsim.render.parallel_view import ParallelView
from gaitsim.render.terminal.parallel import ParallelPicture
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.storage.files.folder import command
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.study.running import read_cells
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.widgets.cells import Picture
from gaitsim.tui.widgets.lines import Lines
from gaitsim.tui.widgets.member_plot import MemberCells


class ParallelPlot(MemberCells[ParallelPicture], can_focus=True):
    """Lines across parallel axes; arrow keys and clicks select an axis and an item.

    Attributes:
        view: the items; None before they are read.
        item: index of the selected item; None for none.
    """

    BINDINGS = bindings("parallel cursor")

    @dataclass
    class Selected(Message):
        """Posted when another item is selected."""

        item: int | None

    def __init__(self) -> None:
        super().__init__("reading …")
        self.view: ParallelView | None = None
        self.item: int | None = None
        self._order: list[int] = []
        self._flipped: frozenset[int] = frozenset()
        self._axis = 0

    def show(self, view: ParallelView, item: int | None) -> None:
        """Show items, with one of them selected."""
        self.view, self._order = view, [*range(len(view.axes))]
        self._axis = len(self._order) - 1
        self._picture = None
        self.select(item)

    def select(self, item: int | None) -> None:
        """Select an item."""
        self.item = item
        self.post_message(self.Selected(item))
        self.redraw()

    def make_picture(self, columns: int, rows: int) -> ParallelPicture | None:
        if self.view is None or not len(self.view.scores):
            return None
        return ParallelPicture(
            self.view,
            self._order,
            self._flipped,
            columns,
            rows,
            levels=self.levels,
            shaded=self.app.no_color,
        )

    def picture(self, columns: int, rows: int) -> Picture:
        found = self._find()
        assert found is not None, "else the placeholder is shown"
        return found.draw(self._axis, self.item)

    def action_axis(self, steps: int) -> None:
        self._axis = min(max(self._axis + steps, 0), len(self._order) - 1)
        self.redraw()

    def action_item(self, up: int) -> None:
        found = self._find()
        if found is not None:
            self.select(found.beside(self._axis, self.item, up))

    def on_click(self, event: events.Click) -> None:
        found = self._find()
        if found is not None and found.fits:
            self._axis, item = found.nearest(event.x, event.y)
            self.select(item)

    def flip(self) -> None:
        """Turn the selected axis upside down."""
        self._flipped ^= {self._order[self._axis]}
        self._picture = None
        self.redraw()

    def move(self, steps: int) -> None:
        """Move the selected axis to the left or to the right."""
        place = min(max(self._axis + steps, 0), len(self._order) - 1)
        self._order.insert(place, self._order.pop(self._axis))
        self._axis, self._picture = place, None
        self.redraw()


class Parallel(GaitScreen):
    """Items in parallel coordinates.

    Args:
        load: function that reads the items, in a thread.
        about: name of the run or study, for the title.
        line: command that draws the same.
        run: folder of the run whose members are shown; None for cells of a study.
        which: member initially selected; the best if it is not a member.
    """

    HELP_TEXT = """
Each line is a member of a front or an archive, or a cell of a study; it crosses each axis at its
value, and its colour is its score. Between two axes, parallel lines have values that rise together,
and crossing lines have values that conflict. The arrow beside a name points to better values.

- `←` `→` select an axis, `↑` `↓` the next line along it; a click selects the nearest line. The
  values of the selected line are listed below.
- **Flip** turns the selected axis upside down, and `<` `>` move it.
- **Best** selects the line with the highest score.
- **Replay**, **Why**, **Export** and the **Laboratory** apply to the selected member.
"""
    BINDINGS = bindings("parallel")
    DEFAULT_CSS: ClassVar[str] = """
    Parallel {
        & ParallelPlot { margin: 0 1; }
        & ParallelPlot:focus { background-tint: $foreground 3%; }
        & Lines { height: auto; padding: 0 1; }
    }
    """
    AUTO_FOCUS = "ParallelPlot"

    def __init__(
        self,
        load: Callable[[], ParallelView],
        about: str,
        line: str,
        run: Path | None = None,
        which: Which = None,
    ) -> None:
        super().__init__()
        self._load, self._line, self._run = load, line, run
        self._initial = which.number - 1 if isinstance(which, Member) else None
        self.plot = ParallelPlot()
        self._values = Lines()
        self.title, self.sub_title = about, "parallel coordinates"

    @classmethod
    def of_run(cls, run: Path, which: Which = None) -> "Parallel":
        """Return the screen of a run's members."""
        line = command("plot", run, "--kind", "parallel")
        return cls(lambda: ParallelView.of_run(RunSnapshot(run)), run.name, line, run, which)

    @classmethod
    def of_study(cls, folder: Path) -> "Parallel":
        """Return the screen of a study's finished cells."""

        def load() -> ParallelView:
            study, found = read_cells(folder)
            return ParallelView.of_study(study, found)

        return cls(load, folder.name, command("study", folder))

    def content(self) -> ComposeResult:
        yield self.plot
        yield self._values

    def on_mount(self) -> None:
        self._read()

    @work(group="read")
    async def _read(self) -> None:
        try:
            view = await self.in_thread(self._load)
        except (GaitsimError, OSError) as error:
            self.plot.show_message(visible_lines(str(error)))
            return
        count = len(view.scores)
        self.sub_title = f"{count:,} {view.items} in parallel coordinates"
        self.plot.show_message("no gait yet: every individual has failed so far")
        first = self._initial
        self.plot.show(view, first if first is not None and first < count else view.best)

    @on(ParallelPlot.Selected)
    def _selected(self) -> None:
        """List the values of the selected item."""
        view, item = self.plot.view, self.plot.item
        if view is not None and item is not None:
            self._values.show(self._describe(view, item))
        self.refresh_bindings()

    def _describe(self, view: ParallelView, item: int) -> Sequence[Text]:
        text = Text(f"{view.items.removesuffix('s')} {item + 1:,}", "bold", end="")
        text.append(f" of {len(view.scores):,}", "not bold")
        text.append(" ★" if item == view.best else "")
        for axis in view.axes:
            value = f"{visible(axis.name)} {visible(axis.text(item))}"
            text.append("   " + value.replace(" ", "\N{NO-BREAK SPACE}"), "not bold")
        return [*text.wrap(self.app.console, max(self.size.width - 2, 20))][:6]

    def action_best(self) -> None:
        if self.plot.view is not None:
            self.plot.select(self.plot.view.best)

    def action_flip(self) -> None:
        self.plot.flip()

    def action_move(self, steps: int) -> None:
        self.plot.move(steps)

    @property
    def choice(self) -> RunChoice | None:
        item = self.plot.item
        if self._run is None or item is None:
            return None
        return RunChoice(self._run, Member(item + 1))

    def command_line(self) -> str:
        return self._line

    def obstacle(self, action: str) -> str:
        if action in ("replay", "why", "export", "laboratory") and self.choice is None:
            return "No member of a run is selected."
        if action in ("best", "flip", "move") and self.plot.view is None:
            return "Nothing is shown yet."
        return super().obstacle(action)
