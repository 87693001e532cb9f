"""Compare: the curves of several runs in one plot and the options that differ."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from rich.cells import cell_len
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.reactive import reactive
from textual.widgets import DataTable, Static

from gaitsim.render.series import run_curves
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.storage.compare_runs import (
    AXES,
    QUANTITIES,
    ComparedRun,
    RunsReader,
    comparison_table,
    fair_axis,
    quantity_label,
    warning,
)
from gaitsim.storage.files.folder import command
from gaitsim.tui.formatting import clip, clip_name
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen, RunChoice
from gaitsim.tui.widgets.curves import Curves

EVERY = 1.0  # seconds between two checks for new generations
NAME = 18  # maximum columns of a run's name
VALUE = 40  # maximum columns of an option's value


class Compare(GaitScreen):
    """The screen that compares runs.

    Args:
        runs: folders of the runs.
    """

    HELP_TEXT = """
Curves of several runs in one plot, updated while runs evolve.

- **Quantity**: the best, mean or median score of each generation, or the diversity of the
  population. Scores of different fitness functions, or of different options of one, are not
  comparable: a warning names the options.
- **Axis**: the horizontal axis counts generations, evaluations or seconds. Larger populations
  have more expensive generations, so evaluations are the default if populations differ.
- The table lists the state of each run, and the options that differ. If an option changed during a
  run, the table names the generation, and the curves have a dotted line there.
- Two runs may differ by chance alone. **Statistics** repeats their experiments and tests the
  scores.
- Left and right choose a run; **open** it, or **replay** its champion. With two runs, the other
  champion is shown beside it.
"""
    BINDINGS = bindings("compare")
    DEFAULT_CSS = """
    Compare {
        & #problems { height: auto; max-height: 30%; padding: 0 1; color: $error; }
        & #warning { height: auto; max-height: 3; padding: 0 1; color: $warning; }
        & Curves { height: 3fr; margin: 0 1; }
        & DataTable {
            height: 2fr; min-height: 6;
            & > .datatable--fixed { background: $background; color: $text-muted; }
            & > .datatable--cursor, &:focus > .datatable--cursor, & > .datatable--header-cursor {
                background: $primary 25%; color: $foreground; text-style: none;
            }
        }
    }
    """

    quantity: reactive[str] = reactive(QUANTITIES[0], init=False)
    by: reactive[str] = reactive(AXES[0], init=False)

    def __init__(self, runs: Sequence[Path]) -> None:
        super().__init__()
        self._by_chosen = False
        self._paths = tuple(runs)
        self._runs: tuple[ComparedRun, ...] = ()
        self._reader = RunsReader(runs)

    def content(self) -> ComposeResult:
        yield Static(id="problems")
        yield Static(id="warning")
        yield Curves(message="reading …", whole=True, id="curves")
        yield DataTable(id="table", cursor_type="column", fixed_columns=1)

    def on_mount(self) -> None:
        self.query_one("#problems").display = self.query_one("#warning").display = False
        self.query_one("#table").focus()
        self._update_title()
        self._look()
        self.set_interval(EVERY, self._look_again)

    def _look_again(self) -> None:
        if self.is_current and not self.is_busy("compare"):
            self._look()

    @work(group="compare")
    async def _look(self) -> None:
        """Read the runs and show them if they have changed."""
        runs = await self.in_thread(self._reader.read)
        if runs != self._runs:
            self._show(runs)

    def _show(self, runs: tuple[ComparedRun, ...]) -> None:
        self._runs = runs
        if not self._by_chosen:
            self.set_reactive(Compare.by, fair_axis(runs))
            self._update_title()
        self._draw()
        self._fill()
        problems = Text("\n").join(
            Text(f"{visible(one.label)}: {visible_lines(str(one.problem))}")
            for one in runs
            if one.problem
        )
        self._show_panel("#problems", problems)
        text = warning(runs)
        self._show_panel("#warning", Text(f"⚠ {visible(text)}") if text else Text())
        self.refresh_bindings()

    def _show_panel(self, panel: str, text: Text) -> None:
        shown = self.query_one(panel, Static)
        shown.update(text)
        shown.display = bool(text)

    def _draw(self) -> None:
        drawn = [one for one in self._runs if one.history]
        series = [
            replace(one, name=clip_name(one.name, NAME))
            for one in run_curves(drawn, self.quantity, self.by)
        ]
        marks = sorted({mark for one in drawn for mark in one.stage_marks(self.by)})
        self.query_one(Curves).set_series(
            series,
            marks,
            x_label=self.by,
            y_label=quantity_label(self.quantity),
            message="no generation is finished yet",
        )

    def _fill(self) -> None:
        """Fill the table: one row per fact or option and one column per run."""
        shown = self.query_one(DataTable)
        at, scrolled = shown.cursor_column, shown.scroll_offset
        shown.clear(columns=True)
        rows = [[clip(cell, VALUE) for cell in (row.key, *row.values)] for row in
                comparison_table(self._runs)]  # fmt: skip
        for number, heading in enumerate([Text(), *self._headings()]):
            # The table's own widths would arrive only after it is first drawn.
            width = max(heading.cell_len, *(cell_len(row[number]) for row in rows))
            shown.add_column(heading, key=str(number), width=width)
        for row in rows:
            shown.add_row(*map(Text, row))
        shown.move_cursor(column=min(max(at, 1), len(self._runs)), animate=False)
        shown.scroll_to(scrolled.x, scrolled.y, animate=False)

    def _headings(self) -> Iterator[Text]:
        """Yield the names of the runs, with samples of their curves."""
        curves = self.query_one(Curves)
        line = 0
        for one in self._runs:
            heading = Text(no_wrap=True)
            if one.history:
                heading.append_text(curves.sample(line)).append(" ")
                line += 1
            yield heading.append(clip_name(one.label, NAME))

    def _update_title(self) -> None:
        self.sub_title = f"{quantity_label(self.quantity)} by {self.by}"

    def watch_by(self) -> None:
        self._update_title()
        self._draw()

    watch_quantity = watch_by

    def notify_style_update(self) -> None:
        super().notify_style_update()
        if self._runs:
            self.call_after_refresh(self._fill)

    @property
    def _chosen(self) -> ComparedRun | None:
        """The run under the cursor."""
        at = self.query_one(DataTable).cursor_column - 1 if self.is_mounted else -1
        return self._runs[at] if 0 <= at < len(self._runs) else None

    @on(DataTable.ColumnHighlighted)
    def _moved(self) -> None:
        self.refresh_bindings()

    @on(DataTable.ColumnSelected)
    def action_open(self) -> None:
        self.open_listed(self._chosen)

    def action_replay(self) -> None:
        run = self._chosen
        if run is not None:
            others = [one.path for one in self._runs if one is not run]
            beside = others[0] if len(others) == 1 else None
            self.show_screen("replay.Replay", run.path, beside=beside)

    def action_quantity(self) -> None:
        self.quantity = _next(QUANTITIES, self.quantity)

    def action_by(self) -> None:
        self._by_chosen = True
        self.by = _next(AXES, self.by)

    @property
    def choice(self) -> RunChoice | None:
        run = self._chosen
        others = [one.path for one in self._runs if one is not run]
        return None if run is None else RunChoice(run.path, others=others)

    @property
    def to_verify(self) -> Path | None:
        run = self._chosen
        return run.path if run is not None and run.generation else None

    def command_line(self) -> str:
        first, *others = self._paths
        return command("differences", first, *others)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        match action:
            case "quantity" | "by":
                return any(one.history for one in self._runs)
            case "replay" | "steer" | "on_individual":
                run = self._chosen
                return run is not None and run.champion is not None
        return super().check_action(action, parameters)


def _next(words: Sequence[str], word: str) -> str:
    return words[(words.index(word) + 1) % len(words)]
