"""The title bar of a screen."""

from contextlib import suppress

from textual import widgets
from textual.dom import NoScreen
from textual.events import Mount
from textual.widgets._header import HeaderTitle


class Header(widgets.Header):
    """A header that tolerates its screen being closed while it is mounted.

    Textual's header would not find its title, and the app would end with a traceback.
    """

    def on_mount(self, event: Mount) -> None:
        event.prevent_default()  # Textual's own
        for node in (self.app, self.screen):
            for attribute in ("title", "sub_title"):
                self.watch(node, attribute, self._show_title)

    def _show_title(self) -> None:
        with suppress(NoScreen):
            for title in self.query(HeaderTitle):
                title.update(self.format_title())
