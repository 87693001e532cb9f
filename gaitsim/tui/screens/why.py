"""Explanation of a score: the terms of an individual and its gait."""

from collections.abc import Callable, Iterator
from pathlib import Path

from rich.table import Table
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import has_worlds
from gaitsim.gait import GaitAnalysis, analyse_individual, play_on_twin
from gaitsim.gait.changed import has_twin
from gaitsim.gait.worlds import check_gait, compare_blind, evaluate_unseen
from gaitsim.individual import Individual, Which
from gaitsim.render.terminal.explanation import (
    Passage,
    check_results,
    compare_with_twin,
    explanation,
    feedback_results,
    travel_and_stability,
    world_results,
)
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.storage.files.folder import command
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.replay_loading import describe, options_of

WORLDS = 100


class Why(GaitScreen):
    """The breakdown of a score.

    Args:
        run: folder of the run.
        which: individual to explain; None is the champion.
    """

    HELP_TEXT = """
The terms behind the score of an individual, and its gait.

- **Over time**: the terms that the score would have if the motion had ended at that time.
- **Over the generations**: the terms of the best individual of the first generation and of this
  one, and the means of their populations.
- A term dominates if it makes up 60 % of the sum of all absolute terms.
- Below: the gait's name, signs of exploits, travel, slip and stability.
- A robot with reflexes: its yaw and distance with servo horns 2° off, with and without reflexes.
- **Physics** plays the same joint angles on the body's twin in rigid-body physics, if it has one.
- **Worlds** plays the gait in 100 unseen worlds, if its body has conditions, and shows the
  distance, the falls, and the conditions that reduce the score.
- To repeat the gait with delayed, slow and inaccurate servos, press `e` on the run, choose
  *Analysis* and set *perturb*.
"""
    BINDINGS = bindings("why")
    DEFAULT_CSS = """
    Why {
        & VerticalScroll { height: 1fr; padding: 0 1; }
        & Static { height: auto; margin-bottom: 1; }
        & .heading, & .failure, & .warning { margin: 0; }
        & .heading { text-style: bold; }
        & .failure { color: $error; }
        & .warning { color: $warning; }
    }
    """

    def __init__(self, run: Path, which: Which = None) -> None:
        super().__init__()
        self._run, self._which = run, which
        self._individual: Individual | None = None
        self._physics = self._worlds = False
        self.sub_title = "score analysis"

    def content(self) -> ComposeResult:
        with VerticalScroll():
            yield Static(f"reading {describe(self._which)} …", id="why-state")

    @work(group="read")
    async def on_mount(self) -> None:
        scroll = self.query_one(VerticalScroll)
        scroll.focus()
        state = self.query_one("#why-state", Static)
        try:
            found, sections, gait = await self.in_thread(_read, self._run, self._which)
        except GaitsimError as error:
            state.update(Text(visible_lines(str(error))))
            return
        state.update(Text(visible(found.title), style="bold"))
        await scroll.mount(
            *(part for section in sections for part in _section_widgets(section)),
            *_gait_widgets(gait),
        )
        self._individual = found
        self.refresh_bindings()
        self._append("checking whether the gait holds …", self._check, follow=False)

    def action_physics(self) -> None:
        """Play the gait on the body's twin and show how well it transfers."""
        self._physics = True
        self._append("simulating …", lambda individual, _: (_physics_section(individual),))

    def action_worlds(self) -> None:
        """Evaluate the gait in unseen worlds and show the results."""
        self._worlds = True
        self._append("playing in unseen worlds …", self._evaluate_worlds)

    @work
    async def _append(
        self,
        doing: str,
        found: Callable[[Individual, Static], tuple[Passage, ...]],
        follow: bool = True,
    ) -> None:
        """Show a line while a thread computes sections, then the sections; scroll to them."""
        self.refresh_bindings()
        scroll, waiting = self.query_one(VerticalScroll), Static(doing)
        await scroll.mount(waiting)
        if follow:
            scroll.scroll_end(animate=False)
        assert self._individual is not None
        try:
            sections = await self.in_thread(found, self._individual, waiting)
        except GaitsimError as error:
            waiting.update(Text(visible_lines(str(error))))
            return
        await scroll.mount(*(part for section in sections for part in _section_widgets(section)))
        await waiting.remove()
        if follow:
            scroll.scroll_end(animate=False)

    def _check(self, individual: Individual, _: Static) -> tuple[Passage, ...]:
        """Check whether the gait holds, and what its reflexes are worth, in a thread."""
        workers = _workers(individual)
        checks = check_gait(individual, workers=workers)
        feedback = compare_blind(individual, workers=workers)
        return (
            *((check_results(checks),) if checks else ()),
            *((feedback_results(feedback),) if feedback else ()),
        )

    def _evaluate_worlds(self, individual: Individual, waiting: Static) -> tuple[Passage, ...]:
        """Evaluate in unseen worlds, in a thread, and show the progress."""
        done = 0

        def advance(worlds: int) -> None:
            nonlocal done
            done += worlds
            if not self.app.is_running or self not in self.app.screen_stack:
                raise GaitsimError("the screen was closed")
            self.app.call_from_thread(waiting.update, f"{done} of {WORLDS} unseen worlds …")

        workers = _workers(individual)
        return tuple(
            world_results(evaluate_unseen(individual, WORLDS, workers=workers, advance=advance))
        )

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        found = self._individual
        if action == "physics":
            return found is not None and not self._physics and has_twin(found)
        if action == "worlds":
            return found is not None and not self._worlds and has_worlds(found.experiment)
        return super().check_action(action, parameters)

    def command_line(self) -> str:
        physics = ("--physics",) if self._physics else ()
        worlds = ("--worlds", WORLDS) if self._worlds else ()
        return command("analyse", self._run, *options_of(self._which), *physics, *worlds)


def _physics_section(individual: Individual) -> Passage:
    return compare_with_twin(individual, play_on_twin(individual))


def _workers(individual: Individual) -> int | None:
    """Return the number of workers; worker processes would interfere with the app's terminal."""
    return None if individual.experiment.organism.threads else 1


def _read(path: Path, which: Which) -> tuple[Individual, tuple[Passage, ...], GaitAnalysis]:
    """Return the individual, the explanation of its score, and its gait."""
    run = RunSnapshot(path)
    found = run.individual(which)
    return found, tuple(explanation(found, run.history)), analyse_individual(found)


def _gait_widgets(gait: GaitAnalysis) -> Iterator[Static]:
    yield Static(Text(visible(f"Gait: {gait.name.name}")), classes="heading")
    yield Static(Text(visible(gait.name.reason)))
    for flag in gait.flags:
        yield Static(Text(visible(f"Likely exploit: {flag.name}. {flag.seen}")), classes="failure")
    for warning in gait.warnings:
        yield Static(Text(visible(warning)), classes="warning")
    yield from _section_widgets(travel_and_stability(gait))


def _section_widgets(section: Passage) -> Iterator[Static]:
    """Yield a section's heading, warnings, table and notes."""
    above = (("heading", section.title), ("failure", section.failure), ("warning", section.warning))
    for kind, words in above:
        if words:
            yield Static(Text(visible_lines(words)), classes=kind)
    if section.columns:
        table = Table(box=None, pad_edge=False, header_style="bold")
        for name in section.columns:
            table.add_column(Text(name), justify="right" if name in section.numbers else "left")
        for row in section.rows:
            table.add_row(*(Text(visible(cell)) for cell in row))
        yield Static(table)
    if section.notes:
        yield Static(Text("\n".join(map(visible, section.notes))))
