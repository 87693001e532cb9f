"""The app: which screens there are, and how one comes to another."""

from pathlib import Path
from typing import ClassVar

from textual.app import App
from textual.binding import Binding, BindingType

from gaitsim.errors import GaitsimError
from gaitsim.tui.screens.home import Home


class GaitsimApp(App[None]):
    """Assemble, watch, steer, replay.

    Screens are imported when they are first shown, so that the first paint waits for none of
    NumPy's compilers or plotting libraries.

    Args:
        folder: where runs are.
    """

    TITLE = "gaitsim"
    CSS_PATH = "styles.tcss"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q", "quit", "Quit", id="app.quit"),
    ]

    def __init__(self, folder: Path = Path("runs")) -> None:
        super().__init__()
        self.folder = folder

    def on_mount(self) -> None:
        """Begin at home."""
        self.push_screen(Home())

    def open_run(self, run: Path) -> None:
        """Show a run live: evolving here, elsewhere, or at rest."""
        from gaitsim.tui.screens.live import Live

        self.push_screen(Live(run))

    def open_new(self, experiment: str | None = None) -> None:
        """Assemble a new run, from a preset's name or an experiment file."""
        from gaitsim.tui.screens.new import New

        self.push_screen(New(experiment))

    def open_replay(self, run: Path, generation: int | None = None, beside: Path | None = None) -> None:
        """Replay a champion, beside another run's if one is given."""
        from gaitsim.tui.screens.replay import Replay

        self.push_screen(Replay(run, generation, beside))

    def open_compare(self, runs: list[Path]) -> None:
        """Lay the curves of several runs over each other."""
        from gaitsim.tui.screens.compare import Compare

        self.push_screen(Compare(runs))

    def open_plugins(self) -> None:
        """Show what is installed."""
        from gaitsim.tui.screens.plugins import Plugins

        self.push_screen(Plugins())

    def tell(self, error: GaitsimError) -> None:
        """Say what went wrong, and what to do, as text without markup."""
        self.notify(str(error), title="", severity="error", markup=False, timeout=10)
