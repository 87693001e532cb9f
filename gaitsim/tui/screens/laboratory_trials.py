"""The trials of an adaptation: a table and the map of expected performance after them."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from string import ascii_lowercase
from typing import Any

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import DataTable

from gaitsim.adaptation.adaptation import Adaptation
from gaitsim.adaptation.trials import Trial, predict_performance
from gaitsim.contracts import Members
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.screens.laboratory_pane import colour_of
from gaitsim.tui.widgets.archive_map import ArchiveMap

COLUMNS = ("trial", "member", "expected", "measured", "of best")
SIGNS = ("", *"123456789", *ascii_lowercase)  # of trials on the map, indexed by number
BEST = "★"


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
        self.map.marks = {trial.member: mark(trial, best) for trial in trials}
        self.map.display = True
        words = {name: visible(name) for name in names} | {"score": f"expected{unit}"}
        self.map.show(view, names, words, trials[-1].member if trials else None)

    def _list(self, adaptation: Adaptation) -> None:
        self.table.clear()
        prior, best, colours = adaptation.prior, adaptation.best, self.app.theme_variables
        unit = visible(f" {prior.unit}".rstrip())
        for trial in adaptation.trials:
            kept = trial.measured / prior.best
            self.table.add_row(
                Text(f"{trial.number}{f' {BEST}' if trial is best else '  '}", justify="right"),
                Text(f"{trial.member:,}", justify="right"),
                Text(f"{number(trial.expected, 2)} ± {number(trial.deviation, 2)}{unit}"),
                Text(f"{number(trial.measured, 2)}{unit}", justify="right"),
                Text(f"{number(100 * kept, 0)} %", colours[colour_of(kept)], justify="right"),
            )
        self.table.move_cursor(row=len(adaptation.trials) - 1)

    @on(ArchiveMap.Moved)
    def _moved(self, event: ArchiveMap.Moved) -> None:
        event.stop()


def expected_view(adaptation: Adaptation, members: Members) -> ArchiveView:
    """Return the map of an atlas, with the performance expected after the trials as scores."""
    prediction = predict_performance(
        adaptation.prior, adaptation.trials, adaptation.session.settings
    )
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
