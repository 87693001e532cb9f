"""Textual's driver for the browser, for an app that ends when its server does."""

import os
from pathlib import Path
from threading import Lock
from typing import Any

from textual.app import App
from textual.color import Color
from textual.drivers.web_driver import WebDriver
from textual.messages import ExitApp

GRACE = 10.0  # seconds for an app to end by itself


class PipeDriver(WebDriver):
    """A web driver that ends its app when standard input closes, as when the server is killed."""

    def __init__(self, app: App[Any], **options: Any) -> None:
        super().__init__(app, **options)
        self._write = self._write_whole  # type: ignore[assignment]
        self._writing = Lock()

    def _write_whole(self, data: bytes) -> None:
        """Write a packet: whole, and not between the parts of another thread's."""
        with self._writing:
            try:
                while data:
                    data = data[os.write(self.fileno, data) :]
            except BrokenPipeError:
                pass  # the server is gone; standard input closes, too

    def start_application_mode(self) -> None:
        """Begin, and tell the page the colour of the ground now and whenever it is another."""
        super().start_application_mode()
        self._tell_ground()
        self._app.theme_changed_signal.subscribe(self._app, lambda _: self._tell_ground())

    def _tell_ground(self) -> None:
        ground = Color.parse(self._app.theme_variables["background"])
        self.write_meta({"type": "ground", "colour": ground.hex6})

    def show_page(self, file: Path) -> None:
        """Have the browser that shows the app open a page that gaitsim has written."""
        self.write_meta({"type": "page", "path": str(file.absolute())})

    def run_input_thread(self) -> None:
        """Pass input on until it ends, and end the app then."""
        super().run_input_thread()
        if not self.exit_event.is_set():
            self._app.post_message(ExitApp())
            if not self.exit_event.wait(GRACE):
                os._exit(1)
