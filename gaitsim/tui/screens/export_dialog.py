"""Choose what to make of a run in the background."""

import shlex
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import OptionList, Static
from textual.widgets.option_list import Option

PRODUCTS: dict[str, tuple[str, ...]] = {
    "Gait for MATLAB and Octave (.mat)": ("export", "--format", "mat"),
    "Gait as a table (.csv)": ("export", "--format", "csv"),
    "Gait for NumPy (.npz)": ("export", "--format", "npz"),
    "Gait for servos, in degrees and milliseconds": ("export", "--format", "servo"),
    "Plot of the fitness curve": ("plot", "--kind", "fitness"),
    "Plot of the terms": ("plot", "--kind", "terms"),
    "Plots of every kind": ("plot", "--kind", "all"),
    "Video (MP4)": ("video", "--format", "mp4"),
    "Video (GIF)": ("video", "--format", "gif"),
    "Analysis: which gait, and why it scored": ("analyse",),
    "Analysis with late and inexact servos": ("analyse", "--perturb"),
    "Network that imitates the champion": ("imitate",),
}


class ExportDialog(ModalScreen[tuple[str, ...] | None]):
    """Ask what to make of the run in the folder `run`; return the arguments of the command."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Cancel", id="export.cancel", tooltip="Make nothing"),
    ]

    def __init__(self, run: Path) -> None:
        super().__init__()
        self._run = run

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog", id="export") as box:
            box.border_title = "Export"
            box.border_subtitle = "enter makes it, esc cancels"
            yield Static(Text(f"of {self._run}"), classes="dialog-about")
            yield OptionList(*(Option(Text(title)) for title in PRODUCTS))
            yield Static(id="export-command", classes="command")

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        line = shlex.join(["gaitsim", *self._arguments(event.option_index)])
        self.query_one("#export-command", Static).update(Text(f"$ {line}"))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(self._arguments(event.option_index))

    def _arguments(self, index: int) -> tuple[str, ...]:
        verb, *more = list(PRODUCTS.values())[index]
        return (verb, str(self._run), *more)
