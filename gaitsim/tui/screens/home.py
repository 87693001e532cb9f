"""Home: the runs there are."""

from textual.app import ComposeResult
from textual.widgets import Footer, Header, Static

from gaitsim.tui.screens.base import GaitScreen


class Home(GaitScreen):
    """The table of runs."""

    def compose(self) -> ComposeResult:
        """Header, table, footer."""
        yield Header()
        yield Static("runs")
        yield Footer()
