"""Panels of the laboratory: walks of a body, and the trials of an adaptation."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np
from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import DataTable, Static

from gaitsim.plugin import GaitsimError, Members
from gaitsim.plugin.gait import (
    can_be_damaged,
    damage_body,
    frames_before_fall,
    has_twin,
    play_on_twin,
    twin_of,
    with_damage,
)
from gaitsim.plugin.pictures import ArchiveView, Plan, number, plan_of, visible, visible_lines
from gaitsim.plugin.runs import Individual, RunSnapshot, Which
from gaitsim.screen import ArchiveMap, BodyCanvas, clip
from gaitsim_adaptation.adaptation import Adaptation
from gaitsim_adaptation.damage import Choice, Legs, damage_texts
from gaitsim_adaptation.prior import DEFAULT_MEASURE
from gaitsim_adaptation.trials import Trial, predict_performance

FPS = 12  # three bodies move at once
WALKS, LIMPS = 0.9, 0.5  # minimum shares of the intact distance for the first two colours
BAR = 12  # cells of a full bar
FALLEN = "✗ fell"
COLUMNS = ("trial", "member", "expected", "measured", "of best")
SIGNS = ("", *"123456789", *ascii_lowercase)  # of trials on the map, indexed by number
BEST = "★"


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk of an individual on a body.

    Attributes:
        individual: individual with a computed skeleton.
        forward: distance walked, m.
        fell: time of the fall, s; None if it did not fall.
    """

    individual: Individual
    forward: float
    fell: float | None


@dataclass(frozen=True, eq=False)
class LaboratoryRun:
    """A run whose body can be damaged.

    Attributes:
        run: snapshot of the run.
        champion: individual to watch, on the body of the run.
        legs: joints by leg.
        plan: plan of the body.
    """

    run: RunSnapshot
    champion: Individual
    legs: Legs
    plan: Plan

    def check(self, damage: Choice, *, physics: bool) -> None:
        """Check whether the body, or its twin, can have this damage."""
        (twin_of if physics else damage_body)(self.champion.experiment, damage_texts(damage))

    def damaged_legs(self, damage: Choice) -> list[str]:
        """Return the legs that are lost or have a damaged joint."""
        parts = {one.part for one in damage}
        return [leg for leg, joints in self.legs.items() if parts & {leg, *joints}]

    @property
    def unadaptable(self) -> str:
        """The reason why its gait cannot be adapted; '' if it can."""
        if self.run.experiment.search.keeps == "archive":
            return ""
        return "The run is not an atlas: its search keeps no archive. 'gaitsim atlas' evolves one."

    @property
    def has_twin(self) -> bool:
        """Whether the body has a twin in rigid-body physics."""
        return has_twin(self.champion)


def read_subject(path: Path, which: Which = None) -> LaboratoryRun:
    """Read a run."""
    run = RunSnapshot(path)
    champion = run.individual(which)
    legs = champion.experiment.organism.leg_joints()
    if not (legs and can_be_damaged(champion.experiment)):
        raise GaitsimError(
            f"the body {champion.experiment.entries['organism'].name!r} cannot be damaged",
            where=str(path),
            allowed="a body with legs and the option 'damage', such as the spider",
        )
    return LaboratoryRun(run, champion, legs, _plan(champion, legs))


def simulate_walk(individual: Individual, damage: Choice, physics: bool) -> Walk:
    """Simulate an individual on a damaged body, or on its twin in rigid-body physics."""
    found = (play_on_twin if physics else with_damage)(individual, damage_texts(damage))
    _ = found.skeleton  # computed here because it is slow
    forward = found.measurements.get(DEFAULT_MEASURE)
    path = found.skeleton.path
    frames = frames_before_fall(found)
    return Walk(
        found,
        float(path[-1, 0] - path[0, 0]) if forward is None else forward.value,
        None if frames == len(path) else frames / found.skeleton.frame_rate,
    )


def _plan(champion: Individual, legs: Legs) -> Plan:
    """Return the plan of the body with all joints at 0.

    A body that cannot play joint angles is shown at the start of its walk.
    """
    organism = champion.experiment.organism
    if organism.can_play:
        still = np.zeros((1, 2, len(organism.joint_names())))
        return plan_of(organism.skeleton(organism.play(still), 0), legs)
    return plan_of(champion.skeleton, legs)


class WalkPane(Vertical):
    """A walking body.

    Args:
        title: title of the pane.
        message: message shown instead of a body.

    Attributes:
        walk: walk shown; None without one.
        canvas: canvas of the body.
    """

    DEFAULT_CSS = """
    WalkPane {
        width: 1fr; height: 1fr; border-left: solid $border-blurred;
        & > Static { height: 2; padding: 0 1; }
        &:focus-within > Static { background: $surface; }
    }
    """

    def __init__(self, title: str, message: str, **settings: Any) -> None:
        super().__init__(**settings)
        self._pane_title, self._message = title, message
        self.walk: Walk | None = None
        self._share: float | None = None
        self._heading = Static()
        self.canvas = BodyCanvas(message=message, fps=FPS)

    def compose(self) -> ComposeResult:
        yield self._heading
        yield self.canvas

    def on_mount(self) -> None:
        self.canvas.playing = True
        self._title()

    def show(self, walk: Walk, intact: Walk | None, title: str = "") -> None:
        """Show a walk from its beginning, in real time.

        Args:
            walk: walk of the body.
            intact: walk on the intact body, the reference for the share; None for no share.
            title: new title of the pane; '' keeps the title.
        """
        self.walk = walk
        reference = intact.forward if intact is not None else 0.0
        self._share = walk.forward / reference if reference > 0 else None
        self._pane_title = title or self._pane_title
        self.canvas.set_skeleton(walk.individual.skeleton)
        self.canvas.speed, self.canvas.seconds = 1.0, 0.0
        self._title()

    def show_message(self, message: str = "", title: str = "") -> None:
        """Show a message instead of a body; '' for the initial message."""
        self.walk, self._pane_title = None, title or self._pane_title
        self.canvas.set_skeleton(None, visible_lines(message or self._message))
        self._title()

    def on_resize(self) -> None:
        self._title()

    def _title(self) -> None:
        width = max(self.size.width - 3, 8)
        first = Text(clip(self._pane_title, width), "bold", no_wrap=True)
        second = describe_walk(self.walk, self._share, width)
        self._heading.update(Text("\n").join([first, second]))


def colour_of(share: float) -> str:
    """Return the theme colour of a share of the distance on the intact body."""
    return "success" if share >= WALKS else "warning" if share >= LIMPS else "error"


def describe_walk(walk: Walk | None, share: float | None, width: int) -> Text:
    """Return the distance in metres, a bar with its share of the intact one, and any fall."""
    text = Text(no_wrap=True, overflow="ellipsis")
    if walk is None:
        return text
    ink = "foreground" if share is None else colour_of(share)
    text.append(f"{number(walk.forward, 2)} m", f"bold ${ink}")
    if share is not None:
        percent = f" {number(100 * share, 0)} %"
        fallen = len(FALLEN) + 1 if walk.fell is not None else 0
        cells = min(width - text.cell_len - len(percent) - fallen - 1, BAR)
        if cells > 2:
            filled = round(min(max(share, 0.0), 1.0) * cells)
            full = "█" * filled if share <= 1 else "█" * (filled - 1) + "▶"  # beyond the bar
            text.append(" ").append(full, f"${ink}")
            text.append("░" * (cells - filled), "dim")
        text.append(percent, f"${ink}")
    if walk.fell is not None:
        text.append(f" {FALLEN}", "bold $error")
        text.append(f" at {walk.fell:.1f} s", "$error")
    return text


class Trials(Horizontal):
    """The trials of an adaptation, one per row, and the expected performance of all gaits.

    Attributes:
        table: table of the trials; the best has a star.
        map: map of the gaits along two axes, with the trials on it.
    """

    DEFAULT_CSS = """
    Trials {
        & DataTable { width: 50; height: 1fr; overflow-x: hidden; }
        & ArchiveMap { border-left: solid $border-blurred; }
    }
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.table: DataTable[Text] = DataTable(cursor_type="row")
        self.map = ArchiveMap("expected performance of each gait after the trials")
        self.map.can_focus = False

    def compose(self) -> ComposeResult:
        yield self.table
        yield self.map

    def on_mount(self) -> None:
        self.table.add_columns(*COLUMNS)

    def clear(self) -> None:
        """Show no trials."""
        self.table.clear()
        self.map.display = False

    def show(self, adaptation: Adaptation, members: Members, legs: Collection[str]) -> None:
        """Show the trials and put the cursor on the last one.

        Args:
            adaptation: adaptation with its trials.
            members: members of its atlas.
            legs: damaged legs, whose axes are shown if the atlas has any.
        """
        trials, best = adaptation.trials, adaptation.best
        self._list(adaptation)
        view = expected_view(adaptation, members)
        names = axes_of(view, legs)
        unit = visible(f", {adaptation.prior.unit}".rstrip(", "))
        self.map.marks = {one.member: mark(one, best) for one in trials if not one.genome}
        self.map.display = True
        words = {name: visible(name) for name in names} | {"score": f"expected{unit}"}
        self.map.show(view, names, words, trials[-1].member if trials else None)

    def _list(self, adaptation: Adaptation) -> None:
        self.table.clear()
        prior, best = adaptation.prior, adaptation.best
        unit = visible(f" {prior.unit}".rstrip())
        for trial in adaptation.trials:
            kept = trial.measured / prior.best
            self.table.add_row(
                Text(f"{trial.number}{f' {BEST}' if trial is best else '  '}", justify="right"),
                Text(f"{'+' * bool(trial.genome)}{trial.member:,}", justify="right"),
                Text(f"{number(trial.expected, 2)} ± {number(trial.deviation, 2)}{unit}"),
                Text(f"{number(trial.measured, 2)}{unit}", justify="right"),
                Text(f"{number(100 * kept, 0)} %", f"${colour_of(kept)}", justify="right"),
            )
        self.table.move_cursor(row=len(adaptation.trials) - 1)

    @on(ArchiveMap.CursorMoved)
    def _moved(self, event: ArchiveMap.CursorMoved) -> None:
        event.stop()


def expected_view(adaptation: Adaptation, members: Members) -> ArchiveView:
    """Return the map of an atlas, with the performance expected after the trials as scores."""
    prediction = predict_performance(adaptation.prior, adaptation.trials, adaptation.settings)
    view = ArchiveView.of(replace(members, scores=prediction.mean))
    assert view is not None, "members of an atlas have cells"
    return view


def axes_of(view: ArchiveView, legs: Collection[str]) -> tuple[str, ...]:
    """Return the first pair with an axis of one of the legs, or else the first pair."""
    pairs: Sequence[tuple[str, ...]] = view.pairs or (view.names,)
    ours = (
        pair for pair in pairs if any(name.endswith(f" {leg}") for name in pair for leg in legs)
    )
    return next(ours, pairs[0])


def mark(trial: Trial, best: Trial | None) -> str:
    """Return the character of a trial on the map: its number, a letter from 10 on, or a star."""
    if trial is best:
        return BEST
    return SIGNS[trial.number] if trial.number < len(SIGNS) else "+"
