"""An experiment file, with sections, keys and comments in colour."""

from textual.app import ComposeResult
from textual.containers import ScrollableContainer
from textual.geometry import Region
from textual.highlight import highlight
from textual.widgets import Static

AROUND = 2  # minimum lines shown above and below the marked one


class TomlView(ScrollableContainer):
    """An experiment file with one marked line, which is kept visible."""

    DEFAULT_CSS = """
    TomlView { scrollbar-size: 0 1; }
    TomlView Static { width: auto; }
    TomlView.-stale Static { text-opacity: 60%; }
    """

    def __init__(self, id: str) -> None:
        super().__init__(id=id, can_focus=False)
        self._toml = self._key = ""

    def compose(self) -> ComposeResult:
        yield Static("Loading the plugins …")

    def show(self, toml: str) -> None:
        """Show a file; '' dims the previous one, because the experiment has problems."""
        self.set_class(not toml, "-stale")
        if not toml and not self._toml:
            self.query_one(Static).update("The file appears here once there are no problems.")
        if toml and toml != self._toml:
            self._toml = toml
            self.mark_line(self._key)

    def mark_line(self, key: str) -> None:
        """Mark the line of an option, or of a section, and scroll to it."""
        self._key = key
        if not self._toml:
            return
        at = line_of(self._toml, key)
        text = highlight(self._toml, language="toml")
        if at is not None:
            start = sum(len(line) + 1 for line in self._toml.splitlines()[:at])
            end = start + len(self._toml.splitlines()[at])
            text = text.stylize("bold on $primary-muted", start, end)
        self.query_one(Static).update(text)
        self.call_after_refresh(self._scroll_to_line, at or 0)

    def _scroll_to_line(self, line: int) -> None:
        around = Region(0, max(0, line - AROUND), 1, 2 * AROUND + 1)
        self.scroll_to_region(around, animate=False, force=True)


def line_of(toml: str, key: str) -> int | None:
    """Return the line of an option such as 'mutation.rate', else of its section, else None."""
    section, _, name = key.rpartition(".")
    here, found = "", None
    for number, line in enumerate(toml.splitlines()):
        if line.startswith("["):
            here = line.strip("[] ")
            if here in (section, key):
                found = number
        elif here == section and line.partition(" = ")[0] == name:
            return number
    return found
