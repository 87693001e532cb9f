"""Textual's driver for the browser, which ends the app when its server ends."""

import os
from pathlib import Path
from threading import Lock
from typing import Any

from textual.app import App
from textual.color import Color
from textual.drivers.web_driver import WebDriver
from textual.messages import ExitApp

GRACE = 10.0  # seconds to wait for the app to end


class PipeDriver(WebDriver):
    """A web driver that ends its app when standard input closes, as when the server is killed."""

    def __init__(self, app: App[Any], **options: Any) -> None:
        super().__init__(app, **options)
        self._write = self._write_whole  # type: ignore[assignment]
        self._writing = Lock()

    def _write_whole(self, data: bytes) -> None:
        """Write a whole packet without interleaving those of other threads."""
        with self._writing:
            try:
                while data:
                    data = data[os.write(self.fileno, data) :]
            except BrokenPipeError:
                pass  # the server has ended; standard input closes too

    def start_application_mode(self) -> None:
        """Start, and send the page the background colour now and after each change."""
        super().start_application_mode()
        self._send_background()
        self._app.theme_changed_signal.subscribe(self._app, lambda _: self._send_background())

    def _send_background(self) -> None:
        ground = Color.parse(self._app.theme_variables["background"])
        self.write_meta({"type": "ground", "colour": ground.hex6})

    def show_page(self, file: Path) -> None:
        """Open an exported page in the browser that shows the app."""
        self.write_meta({"type": "page", "path": str(file.absolute())})

    def run_input_thread(self) -> None:
        """Forward input until it closes, then end the app."""
        super().run_input_thread()
        if not self.exit_event.is_set():
            self._app.post_message(ExitApp())
            if not self.exit_event.wait(GRACE):
                os._exit(1)
