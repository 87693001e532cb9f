"""A text field that processes keys strictly in the order of arrival."""

from typing import Any

from textual.binding import Binding
from textual.events import Key
from textual.widgets import Input

_NEED_DATA = {"enter", "tab"}  # keys that must wait until the data has been read


class OrderedInput(Input):
    """A field that processes each key completely before the next one.

    Textual passes a key that is not a letter to the parents of a field before its binding runs.
    Letters that arrive together with it, as in a paste, would take effect first.

    Attributes:
        reading: whether Enter and Tab, and the keys after them, wait for `catch_up`.
    """

    def __init__(self, *values: Any, reading: bool = False, **settings: Any) -> None:
        super().__init__(*values, **settings)
        self.reading = reading
        self._held: list[Key] = []

    async def on_key(self, event: Key) -> None:
        if not (event.is_printable or self._own_binding(event)):
            return
        event.stop()
        event.prevent_default()
        if self._held or (self.reading and event.key in _NEED_DATA):
            self._held.append(event)
        else:
            await self._process(event)

    async def catch_up(self) -> None:
        """Process the waiting keys."""
        self.reading = False
        while self._held:  # keys that arrive meanwhile are appended
            await self._process(self._held[0])
            del self._held[0]

    async def _process(self, event: Key) -> None:
        if event.is_printable and event.character:
            self.replace(event.character, *self.selection)
        elif binding := self._own_binding(event):
            await self.app.run_action(binding.action, self)

    def _own_binding(self, event: Key) -> Binding | None:
        """Return the field's own binding of a key."""
        if not self.has_focus:  # the focus has moved in the meantime
            return next(iter(self._bindings.key_to_bindings.get(event.key, ())), None)
        found = self.screen.active_bindings.get(event.key)
        return found.binding if found and found.node is self else None
