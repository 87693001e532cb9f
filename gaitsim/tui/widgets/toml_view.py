"""An experiment file, with sections, keys and comments in colour."""

from textual.app import ComposeResult
from textual.containers import ScrollableContainer
from textual.highlight import highlight
from textual.widgets import Static


class TomlView(ScrollableContainer):
    """An experiment file."""

    DEFAULT_CSS = """
    TomlView { scrollbar-size: 0 1; }
    TomlView Static { width: auto; }
    TomlView.-stale Static { text-opacity: 60%; }
    """

    def __init__(self, id: str) -> None:
        super().__init__(id=id, can_focus=False)
        self._toml = ""

    def compose(self) -> ComposeResult:
        yield Static("Loading the plugins …")

    def show(self, toml: str) -> None:
        """Show a file; '' dims the previous one, because the experiment has problems."""
        self.set_class(not toml, "-stale")
        if not toml and not self._toml:
            self.query_one(Static).update("The file appears here once there are no problems.")
        if toml and toml != self._toml:
            self._toml = toml
            self.query_one(Static).update(highlight(toml, language="toml"))
