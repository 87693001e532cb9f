"""The table of the trials of an adaptation."""

from rich.text import Text
from textual.widgets import DataTable

from gaitsim.adaptation.adaptation import Adaptation
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.screens.laboratory_pane import colour_of

COLUMNS = ("trial", "member", "expected", "measured", "kept")


class TrialTable(DataTable[Text]):
    """The trials of an adaptation, a row each; the best has a star."""

    def on_mount(self) -> None:
        self.cursor_type = "row"
        self.add_columns(*COLUMNS)

    def show(self, adaptation: Adaptation) -> None:
        """Show the trials, and put the cursor on the last one."""
        self.clear()
        prior, best, colours = adaptation.prior, adaptation.best, self.app.theme_variables
        unit = visible(f" {prior.unit}".rstrip())
        for trial in adaptation.trials:
            kept = trial.measured / prior.best
            self.add_row(
                Text(f"{trial.number}{' ★' if trial is best else '  '}", justify="right"),
                Text(f"{trial.member:,}", justify="right"),
                Text(f"{number(trial.expected, 2)} ± {number(trial.deviation, 2)}{unit}"),
                Text(f"{number(trial.measured, 2)}{unit}", justify="right"),
                Text(f"{number(100 * kept, 0)} %", colours[colour_of(kept)], justify="right"),
            )
        self.move_cursor(row=len(adaptation.trials) - 1)
