"""A table of rows that Enter, or a click on the highlighted one, opens."""

from typing import ClassVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widgets import DataTable


class FileTable(DataTable[Text]):
    """A table that offers Enter while the action `open` of its screen works."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "select_cursor", "Open", id="files.open", tooltip="Open it"),
    ]

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "select_cursor":
            return self.screen.check_action("open", ())
        return super().check_action(action, parameters)
