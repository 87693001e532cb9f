"""A map of designs: the cursor changes dimensions, and the design walks beside its figures."""

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive
from textual.widgets import Static

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.pictures import ArchiveView, number, visible, visible_lines
from gaitsim.plugin.runs import Individual, Member, RunSnapshot, command
from gaitsim.screen import ArchiveMap, BodyCanvas, GaitScreen, RunChoice, bindings
from gaitsim_design.maps import DesignMap

FPS = 12
WIDE = 46  # columns for the figures of the original beside those of a design
PAUSE = 0.1  # seconds for which the cursor rests before a design is simulated


class DesignScreen(GaitScreen):
    """The designs of a body on a map, with the one under the cursor walking.

    Args:
        run: folder of the run.

    Attributes:
        found: the map; None until it is read.
        quantity: quantity that colours the map.
    """

    HELP_TEXT = """
How the dimensions of a body change its best gaits.

- **Arrow keys** or a click choose a design: they change its dimensions. It walks on the right with
  the gait of its best replicate, above its figures: means with 95 % intervals over the replicates.
  ▲ and ▼ mark differences from the original beyond the noise of the search.
- **Colour** shows the next quantity. Heat is the RMS torque of the hottest servo as a share of its
  continuous torque. A design on the **plateau** cannot be distinguished from the best.
- **Axes** shows other dimensions, if there are more than two; a cell then shows its best design.
- **Replay**, **Export** and others apply to the design under the cursor.
"""
    BINDINGS = bindings("designs")
    DEFAULT_CSS = """
    DesignScreen {
        & #designs-left { width: 5fr; height: 1fr; padding: 0 1; }
        & #designs-right { width: 4fr; height: 1fr; border-left: solid $border-blurred; }
        & #design { height: auto; }
        & #figures { height: auto; padding: 0 1; }
    }
    """
    AUTO_FOCUS = "ArchiveMap"

    quantity: reactive[str] = reactive("score", init=False, bindings=True)

    def __init__(self, run: Path) -> None:
        super().__init__()
        self.run = run
        self.found: DesignMap | None = None
        self.plot = ArchiveMap("reading the map …")
        self.canvas = BodyCanvas(message="no design yet", fps=FPS)
        self._pair = 0
        self._bodies: dict[int, Individual] = {}
        self.title, self.sub_title = visible(run.name), "map of designs"

    def content(self) -> ComposeResult:
        with Horizontal():
            with Vertical(id="designs-left"):
                yield self.plot
                yield Static(id="design")
            with Vertical(id="designs-right"):
                yield self.canvas
                yield Static(id="figures")

    @work(group="read")
    async def on_mount(self) -> None:
        self.canvas.playing = True
        try:
            found = await self.in_thread(_read, self.run)
        except GaitsimError as error:
            self.plot.show_message(visible_lines(str(error)))
            return
        self.found = found
        self._show(found.member(found.best))
        self.refresh_bindings()

    # The map

    def _show(self, member: int | None) -> None:
        """Colour the map by the quantity, with the cursor on a member."""
        found = self.found
        assert found is not None, "the map was read"
        quantity = found.quantities[self.quantity]
        means = quantity.means[found.held]
        assert found.run.members is not None, "the search keeps an archive"
        # A low value of other quantities is better, and bright like a high score.
        bright = means if quantity.higher else -means
        finite = np.where(np.isfinite(bright), bright, np.nanmin(bright, initial=0.0))
        view = ArchiveView.of(replace(found.run.members, scores=finite))
        assert view is not None, "the archive has cells"
        label = f"{self.quantity} ({quantity.unit})" if quantity.unit else self.quantity
        words = {name: f"{name} (factor)" for name in found.names}
        words["score"] = label if quantity.higher else f"−{label}"
        pairs = view.pairs or ((found.names[0],),)
        marks = {found.member(int(one)): "·" for one in np.flatnonzero(found.plateau)}
        marks |= {found.member(found.original): "o", found.member(found.best): "★"}
        self.plot.marks = {member: mark for member, mark in marks.items() if member}
        self.plot.show(view, pairs[self._pair % len(pairs)], words, member)

    def watch_quantity(self) -> None:
        self._show(self.plot.member)

    @property
    def design(self) -> int | None:
        """The index of the design under the cursor."""
        member = self.plot.member
        return None if self.found is None or member is None else int(self.found.held[member - 1])

    @on(ArchiveMap.CursorMoved)
    def _moved(self) -> None:
        """Describe the design under the cursor, and let it walk once the cursor rests."""
        found, design = self.found, self.design
        if found is None or design is None:
            return
        on_it = "on the plateau" if found.plateau[design] else "below the plateau"
        names = [name for name, index in found.chosen.items() if index == design]
        head = Text(visible(found.label(design)), "bold")
        head.append(
            f"\n{', '.join([*names, on_it])}; o original, ★ best, · plateau", "not bold dim"
        )
        self.query_one("#design", Static).update(head)
        figures = self.query_one("#figures", Static)
        figures.update(_figures(found, design, self.quantity, figures.size.width - 2))
        if not self.is_busy("walk"):
            self._walk()

    @work(group="walk")
    async def _walk(self) -> None:
        """Show the walk of the design under the cursor; repeat if the cursor has moved since."""
        shown = None
        while (member := self.plot.member) is not None and member != shown:
            await asyncio.sleep(PAUSE)
            if member != self.plot.member:
                continue
            assert self.found is not None, "the map was read"
            try:
                if member not in self._bodies:
                    self._bodies[member] = await self.in_thread(_individual, self.found, member)
                self.canvas.set_skeleton(self._bodies[member].skeleton)
            except GaitsimError as error:
                self.canvas.set_skeleton(None, visible_lines(str(error)))
            shown = member

    # Actions

    def action_colour(self) -> None:
        assert self.found is not None, "available only after reading"
        names = [*self.found.quantities]
        self.quantity = names[(names.index(self.quantity) + 1) % len(names)]

    def action_axes(self) -> None:
        self._pair += 1
        self._show(self.plot.member)

    def action_original(self) -> None:
        assert self.found is not None, "available only after reading"
        self.plot.go_to(self.found.member(self.found.original) or None)

    def action_best(self) -> None:
        assert self.found is not None, "available only after reading"
        self.plot.go_to(self.found.member(self.found.best))

    def action_turn(self) -> None:
        self.canvas.action_next_view()

    @property
    def choice(self) -> RunChoice:
        member = self.plot.member
        return RunChoice(self.run, None if member is None else Member(member))

    def command_line(self) -> str:
        return command("design", self.run)

    def obstacle(self, action: str) -> str:
        known = self.found
        if action in ("colour", "original", "best", "replay", "export") and known is None:
            return "The map is still being read, or cannot be read."
        if action == "axes" and (known is None or len(known.names) < 3):
            return "The map has no other dimensions."
        return super().obstacle(action)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "on_individual" and parameters == ("designs",):
            return False
        return super().check_action(action, parameters)


def _read(run: Path) -> DesignMap:
    """Return the map of a run, with its figures computed; called in a thread."""
    found = DesignMap.of(RunSnapshot(run))
    _ = found.quantities
    return found


def _individual(found: DesignMap, member: int) -> Individual:
    """Return a member with its skeleton computed; called in a thread."""
    individual = found.run.individual(Member(member))
    _ = individual.skeleton
    return individual


def _figures(found: DesignMap, design: int, chosen: str, width: int) -> Text:
    """Return the figures of a design with intervals; beside them, if they fit, the original's."""
    wide = width >= WIDE
    text = Text(f"{'':18}{'this design':>15}  {'original':>9}\n" * wide, "dim", no_wrap=True)
    for name, quantity in found.quantities.items():
        means, half = quantity.means, float(quantity.half_widths[design])
        mark = {1: "▲", -1: "▼", 0: " "}[int(quantity.differs[design])]
        more = f" ± {number(half, 2)}" if np.isfinite(half) else ""
        value = f"{number(float(means[design]), 3)}{more}"
        unit = f" ({quantity.unit})" if 0 < len(quantity.unit) < 6 else ""
        other = f" {number(float(means[found.original]), 3):>9}" if wide else ""
        line = f"{name + unit:18}{value:>15}{mark}{other}\n"
        text.append(line, "not dim bold" if name == chosen else "not dim")
    return text
