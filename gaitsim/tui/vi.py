"""The keys of vi in lists, tables and scrolling text: j, k, g, G, Ctrl-D and Ctrl-U."""

from textual.app import App
from textual.binding import Keymap
from textual.containers import ScrollableContainer
from textual.events import Key
from textual.widget import Widget
from textual.widgets import DataTable, OptionList

from gaitsim.tui.actions import ACTIONS, bindings

PREFIX = "list."  # of the IDs of these keys
# The movements, and the action for each in three kinds of widgets.
_MOVES = ("down", "up", "first", "last", "page_down", "page_up")
_LIST = ("cursor_down", "cursor_up", "first", "last", "page_down", "page_up")
_TABLE = ("cursor_down", "cursor_up", "scroll_top", "scroll_bottom", "page_down", "page_up")
_TEXT = ("scroll_down", "scroll_up", "scroll_home", "scroll_end", "page_down", "page_up")
_KEYS = {action.name: action.keys for action in ACTIONS["list"]}


class ViKeys(App[None]):
    """An app in which the keys of vi move in the focused list, table or text.

    Keys of a screen, and letters typed into a field, take precedence.
    """

    BINDINGS = bindings("list")

    def __init__(self) -> None:
        super().__init__()
        self._chosen: Keymap = {}

    def set_keymap(self, keymap: Keymap) -> None:
        super().set_keymap(keymap)
        self._chosen = keymap

    def action_vi(self, move: str) -> None:
        """Move in the widget that has the focus."""
        action = _actions(self.focused).get(move)
        if action is not None:
            getattr(self.focused, f"action_{action}")()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "vi":
            return bool(_actions(self.focused))
        return super().check_action(action, parameters)

    def on_key(self, event: Key) -> None:
        """Move in dialogs too, where the keys of an app are inactive."""
        if not self.screen.is_modal or event.key in self.screen.active_bindings:
            return
        for name, key in _KEYS.items():
            if event.key in self._chosen.get(PREFIX + name, key).split(","):
                event.prevent_default()
                self.action_vi(name.replace("-", "_"))


def _actions(widget: Widget | None) -> dict[str, str]:
    """Return a widget's actions for each movement; {} if it has none."""
    if widget is None or widget.check_consume_key("j", "j"):  # a field
        return {}
    if isinstance(widget, DataTable):
        return dict(zip(_MOVES, _TABLE, strict=True))
    if isinstance(widget, OptionList):
        return dict(zip(_MOVES, _LIST, strict=True))
    if isinstance(widget, ScrollableContainer):
        return dict(zip(_MOVES, _TEXT, strict=True))
    return {}
