"""What can be made of a run, in the background."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.runs.files.folder import command


@dataclass(frozen=True)
class Product:
    """Something that a command makes of a run.

    Attributes:
        title: what it is.
        verb: the command.
        more: its options.
    """

    title: str
    verb: str
    more: tuple[str, ...] = ()


PRODUCTS = (
    Product("Gait for MATLAB and Octave (.mat)", "export", ("--format", "mat")),
    Product("Gait as a table (.csv)", "export", ("--format", "csv")),
    Product("Gait for NumPy (.npz)", "export", ("--format", "npz")),
    Product("Gait for servos, in degrees and milliseconds", "export", ("--format", "servo")),
    Product("Plot of the fitness curve", "plot", ("--kind", "fitness")),
    Product("Plot of the terms", "plot", ("--kind", "terms")),
    Product("Plots of every kind", "plot", ("--kind", "all")),
    Product("Video (MP4)", "video", ("--format", "mp4")),
    Product("Video (GIF)", "video", ("--format", "gif")),
    Product("Analysis: which gait, and why it scored", "analyse"),
    Product("Analysis with late and inexact servos", "analyse", ("--perturb",)),
    Product("Network that imitates the champion", "imitate"),
)


class ExportDialog(ModalScreen[tuple[str, ...] | None]):
    """Asks what is to be made; dismissed with the arguments of the command that makes it.

    Args:
        run: the folder of the run.
    """

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
            yield OptionList(*(Option(Text(product.title)) for product in PRODUCTS))
            yield Static(id="export-command", classes="command")

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        product = PRODUCTS[event.option_index]
        line = command(product.verb, self._run, *product.more)
        self.query_one("#export-command", Static).update(Text(f"$ {line}"))

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        product = PRODUCTS[event.option_index]
        self.dismiss((product.verb, str(self._run), *product.more))
