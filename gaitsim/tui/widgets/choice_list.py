"""A list whose rows need a second click to be chosen."""

from textual.events import Click
from textual.widgets import OptionList


class ChoiceList(OptionList):
    """A list in which a first click highlights a row and a second one chooses it."""

    async def _on_click(self, event: Click) -> None:
        row = event.style.meta.get("option")
        if row is None or row == self.highlighted:
            await super()._on_click(event)
        elif not self.get_option_at_index(row).disabled:
            self.highlighted = row
        event.prevent_default()
