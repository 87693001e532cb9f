"""The first row of the form for a new run: the preset, the name and the seed."""

from collections.abc import Collection, Sequence

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Input, Label, Select

from gaitsim.render.terminal.text import visible
from gaitsim.tui.builder import ExperimentBuilder

KEYS = ("name", "seed")


class ExperimentHead(Horizontal):
    """A choice of presets, and two inputs whose IDs are the keys of their options."""

    def compose(self) -> ComposeResult:
        yield Label("start from ")
        yield Select[str]([], prompt="…", compact=True, id="preset")
        yield Label(" name ")
        yield Input(compact=True, id="name")
        yield Label(" seed ")
        yield Input(compact=True, id="seed", type="text")

    def fill_presets(self, known: Sequence[str], chosen: str) -> None:
        """Offer presets, and select one of them or an experiment file."""
        names = known if chosen in known else [*known, chosen]
        select = self.query_one("#preset", Select)
        with self.prevent(Select.Changed):
            select.set_options([(Text(visible(name)), name) for name in names])
            select.value = chosen

    def fill(self, builder: ExperimentBuilder) -> None:
        """Show the name and the seed."""
        for key in KEYS:
            with self.prevent(Input.Changed):
                text = builder.changes.get(key, str(builder.preset.values[key]))
                self.query_one(f"#{key}", Input).value = text

    def show_problems(self, keys: Collection[str]) -> None:
        """Mark the invalid inputs."""
        for key in KEYS:
            self.query_one(f"#{key}").set_class(key in keys, "-wrong")
