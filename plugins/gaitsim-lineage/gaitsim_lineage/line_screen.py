"""A line of ancestors: the cursor moves through time, and the ancestor walks beside its changes."""

import asyncio
from pathlib import Path

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import DataTable, Static

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.pictures import number, visible, visible_lines
from gaitsim.plugin.runs import (
    Individual,
    RunSnapshot,
    Which,
    command,
    create_run,
    find_individual,
    mark_of,
)
from gaitsim.screen import (
    BodyCanvas,
    Confirm,
    GaitScreen,
    OpenTable,
    RunChoice,
    bindings,
    options_of,
)
from gaitsim_lineage.lineage import Lineage, Step, lineage, signed

FPS = 12
PAUSE = 0.1  # seconds for which the cursor rests before an ancestor is simulated
FEW = 12  # changes that are listed
TRIED = 9  # columns of a gain


class LineScreen(GaitScreen):
    """The ancestors of an individual, with the one under the cursor walking.

    Args:
        run: folder of the run.
        which: the individual; None for the champion.

    Attributes:
        found: the line; None until it is traced.
    """

    HELP_TEXT = """
Where an individual comes from, and which change brought which gain.

- **Arrow keys** walk through time, from the first ancestor at the top to the individual itself. The
  one under the cursor walks on the right, above its changes: a gene with its value before and
  after, or a part of the body that was added or lost.
- For the largest rises, each change was tried alone in the parent, and left out of the child: the
  columns *alone* and *without* have the differences. **Rise** goes to the next of these.
- **Fork** starts a new run from the ancestor under the cursor; **Replay** and **Export** show it.

The search was repeated with its recorded scores, and every ancestor was re-evaluated.
"""
    BINDINGS = bindings("lineage")
    DEFAULT_CSS = """
    LineScreen {
        & #line-left { width: 4fr; height: 1fr; }
        & #line-table { height: 1fr; }
        & #line-text { height: auto; max-height: 40%; padding: 0 1; color: $text-muted; }
        & #line-right { width: 5fr; height: 1fr; border-left: solid $border-blurred; }
        & #line-changes { height: auto; max-height: 50%; padding: 0 1; }
        & #line-changes Static { height: auto; }
    }
    """
    AUTO_FOCUS = "#line-table"

    def __init__(self, run: Path, which: Which = None) -> None:
        super().__init__()
        self.run, self._which = run, which
        self.found: Lineage | None = None
        self.table = OpenTable(id="line-table")
        self.canvas = BodyCanvas(message="tracing the line …", fps=FPS)
        self._bodies: dict[int, Individual] = {}
        self.title, self.sub_title = visible(run.name), "lineage"

    def content(self) -> ComposeResult:
        with Horizontal():
            with Vertical(id="line-left"):
                yield self.table
                yield Static(id="line-text")
            with Vertical(id="line-right"):
                yield self.canvas
                with VerticalScroll(id="line-changes", can_focus=False):
                    yield Static()

    @work(group="read")
    async def on_mount(self) -> None:
        self.canvas.playing = True
        self.table.add_column("who", width=9)
        for name in ("score", "gain"):
            self.table.add_column(name, width=6)
        self.table.add_column("what changed")
        try:
            found = await self.in_thread(_trace, self.run, self._which)
        except GaitsimError as error:
            self.canvas.set_skeleton(None, visible_lines(str(error)))
            return
        for step in found.steps:
            what = visible(step.what or step.how)
            cells = mark_of(step.place)[1:], number(step.score, 3), signed(step.gain)[:6], what
            self.table.add_row(*(Text(cell, "bold" if step.why else "") for cell in cells))
        self.found = found
        self.query_one("#line-text", Static).update(Text(visible(found.paragraph())))
        self.table.move_cursor(row=len(found.steps) - 1)
        self._moved()
        self.refresh_bindings()

    @property
    def index(self) -> int | None:
        """The step under the cursor; None before the line was traced."""
        return None if self.found is None else max(self.table.cursor_row, 0)

    @property
    def step(self) -> Step | None:
        """The ancestor under the cursor."""
        return None if self.found is None or self.index is None else self.found.steps[self.index]

    @property
    def _explained(self) -> list[int]:
        """The rises whose changes were tried one by one, in order of time."""
        steps = () if self.found is None else self.found.steps
        return [index for index, step in enumerate(steps) if step.why]

    @on(DataTable.RowHighlighted)
    def _moved(self) -> None:
        """Describe the ancestor under the cursor, and let it walk once the cursor rests."""
        if self.step is None:
            return
        changes = self.query_one("#line-changes Static", Static)
        changes.update(_describe(self.step, changes.size.width))
        if not self.is_busy("walk"):
            self._walk()

    @work(group="walk")
    async def _walk(self) -> None:
        """Show the walk of the ancestor under the cursor; repeat if it has moved since."""
        shown = None
        while (index := self.index) is not None and index != shown:
            await asyncio.sleep(PAUSE)
            if index != self.index:
                continue
            assert self.found is not None, "the line was traced"
            try:
                if index not in self._bodies:
                    self._bodies[index] = await self.in_thread(_individual, self.found, index)
                self.canvas.set_skeleton(self._bodies[index].skeleton)
            except GaitsimError as error:
                self.canvas.set_skeleton(None, visible_lines(str(error)))
            shown = index

    # Actions

    def action_rise(self) -> None:
        explained, index = self._explained, self.index
        assert index is not None, "available only after tracing"
        later = [one for one in explained if one > index]
        self.table.move_cursor(row=(later or explained)[0])

    @on(DataTable.RowSelected)
    def _opened(self) -> None:
        self.action_replay()

    @work(group="ask")
    async def action_fork(self) -> None:
        """Start a run from the ancestor under the cursor, after a question."""
        step = self.step
        assert step is not None, "available only after tracing"
        about = f"Its first generation is drawn around {step.place}."
        ask = Confirm("Start a new run from this ancestor?", "Start", about)
        if not await self.app.push_screen_wait(ask):
            return
        reference = f"{self.run}{mark_of(step.place)}"
        try:
            path = await self.in_thread(_fork, self.run, reference, step.place.generation)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
            return
        self.notify(f"{path}: starts from {reference}", title="Forked", markup=False)
        self.show_screen("live.Live", path, resume=True)

    def action_turn(self) -> None:
        self.canvas.action_next_view()

    @property
    def choice(self) -> RunChoice:
        return RunChoice(self.run, self._which if self.step is None else self.step.place)

    def command_line(self) -> str:
        return command("lineage", self.run, *options_of(self._which))

    def obstacle(self, action: str) -> str:
        if action in ("rise", "replay", "fork", "export") and self.found is None:
            return "The line is still being traced, or cannot be."
        if action == "rise" and not self._explained:
            return "No rise was explained: its changes cannot be tried one by one."
        return super().obstacle(action)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "on_individual" and parameters == ("lineage",):
            return False
        return super().check_action(action, parameters)


def _trace(run: Path, which: Which) -> Lineage:
    """Return the line of an individual; called in a thread."""
    return lineage(RunSnapshot(run), which)


def _individual(found: Lineage, index: int) -> Individual:
    """Return an ancestor with its skeleton computed; called in a thread."""
    individual = found.individual_of(index)
    _ = individual.skeleton
    return individual


def _fork(run: Path, reference: str, generation: int) -> Path:
    """Create a run that starts from an individual; called in a thread."""
    experiment = RunSnapshot(run).experiment_at(generation)
    return create_run(experiment, run, find_individual(reference))


def _describe(step: Step, width: int) -> Text:
    """Return the changes of a step, as a table if they were tried one by one."""
    room = min(max(width - 2 * TRIED, 16), 40)
    text = Text(f"{step.place}: {step.how}", "bold")
    if step.other is not None and step.how != "mutation":
        text.append(f", with {step.other}", "not bold")
    if step.why:
        text.append(f"\n{visible(step.why)}", "not bold")
    parts = [f"+ {one}" for one in step.added] + [f"− {one}" for one in step.lost]
    text.append("".join(f"\n{visible(one)}" for one in parts), "not bold")
    changes = () if parts else step.changes
    if any(one.tried for one in changes):
        text.append(f"\n{'':{room}}{'alone':>{TRIED}}{'without':>{TRIED}}", "not bold dim")
    for one in changes[:FEW]:
        line = f"\n{visible(str(one))[: room - 1]:{room}}"
        if one.tried:
            line += f"{signed(one.alone):>{TRIED}}{signed(-one.without):>{TRIED}}"
        text.append(line, "not bold")
    if len(changes) > FEW:
        text.append(f"\nand {len(changes) - FEW} more", "not bold dim")
    changed = {name: change for name, change in step.terms.items() if change}
    if len(changed) > 1:
        found = ", ".join(f"{name} {change:+.3g}" for name, change in changed.items())
        text.append(f"\nterms of the score: {visible(found)}", "not bold dim")
    return text
