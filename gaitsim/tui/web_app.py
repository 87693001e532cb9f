"""A served app: the process behind a browser window."""

import asyncio
import json
import shlex
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from aiohttp import WSCloseCode, web
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager

MOST_COLUMNS = 500
MOST_ROWS = 200
FAILED = b"The app has failed. See the reason in the terminal of gaitsim serve."
GRACE = 15.0  # seconds to wait for an app to end; an app allows itself less


def limit_size(width: int, height: int) -> tuple[int, int]:
    """Return the allowed size nearest to the requested one."""
    return min(max(width, 1), MOST_COLUMNS), min(max(height, 1), MOST_ROWS)


class ServedApp(AppService):
    """A Textual app in a process that ends when its window closes.

    Args:
        command: command line of the app.
        websocket: connection to the window.
        downloads: download manager of the server.
        publish: function that serves a page and returns its address on the server.
    """

    def __init__(
        self,
        command: str,
        websocket: web.WebSocketResponse,
        downloads: DownloadManager,
        publish: Callable[[Path], str],
    ) -> None:
        async def write_bytes(data: bytes) -> None:
            # Keep reading after the window has closed, so that the app never blocks on its output.
            with suppress(ConnectionError):
                await websocket.send_bytes(data)

        async def write_str(data: str) -> None:
            with suppress(ConnectionError):
                await websocket.send_str(data)

        async def close() -> None:
            pass  # `run` closes the window once the process has ended and its exit code is known

        super().__init__(
            command,
            write_bytes=write_bytes,
            write_str=write_str,
            close=close,
            download_manager=downloads,
        )
        self._websocket = websocket
        self._publish = publish

    def _build_environment(self, width: int = 80, height: int = 24) -> dict[str, str]:
        environment = super()._build_environment(width, height)
        environment["TEXTUAL_DRIVER"] = "gaitsim.tui.web_driver:PipeDriver"
        environment.pop("GAITSIM_TOKEN", None)
        return environment

    async def _open_app_process(self, width: int = 80, height: int = 24) -> Process:
        self._process = await asyncio.create_subprocess_exec(
            *shlex.split(self.command),
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            env=self._build_environment(width, height),
            start_new_session=True,  # keeps Ctrl-C in the server's terminal from the app
        )
        self._stdin = self._process.stdin
        return self._process

    async def run(self) -> None:
        """Forward the app's output until it ends; then close its window."""
        try:
            await super().run()
        except asyncio.CancelledError:
            task = asyncio.current_task()
            if task is None or task.cancelling():
                raise
            # textual-serve may not have started to read standard error when the app ended.
            if self._process is not None and self._process.stderr is not None:
                errors = await self._process.stderr.read()
                sys.stdout.write(errors.decode("utf-8", "replace"))
        failed = self._process is not None and await self._process.wait()
        if failed:
            await self._websocket.close(code=WSCloseCode.INTERNAL_ERROR, message=FAILED)
        else:
            await self._websocket.close()

    async def on_meta(self, data: bytes) -> None:
        """Handle a request of the app; forward a colour or an address to the window."""
        match json.loads(data):
            case {"type": "ground", "colour": str(colour)}:
                await self.remote_write_str(json.dumps(["ground", colour]))
            case {"type": "page", "path": str(path)}:
                await self.remote_write_str(json.dumps(["page", self._publish(Path(path))]))
            case _:
                await super().on_meta(data)

    async def handle_message(self, text: str) -> None:
        """Forward a message of the page to the app."""
        match _decode(text):
            case ["stdin", str(keys)]:
                await self.send_bytes(keys.encode("utf-8", "replace"))
            case ["resize", {"width": int(width), "height": int(height)}]:
                await self.set_terminal_size(*limit_size(width, height))
            case ["ping", str(sent)]:
                await self.remote_write_str(json.dumps(["pong", sent]))
            case ["focus"]:
                await self.focus()
            case ["blur"]:
                await self.blur()
            case _:
                raise ValueError("not a message")

    async def stop(self) -> None:
        """Ask the app to end, and kill it if it does not."""
        process, task = self._process, self._task
        if process is None or task is None:
            return
        self._task = None
        await self._download_manager.cancel_app_downloads(self.app_service_id)
        try:
            async with asyncio.timeout(GRACE):
                await self.send_meta({"type": "quit"})
                self.stdin.close()
                await process.wait()
        except TimeoutError:
            pass
        finally:
            if process.returncode is None:
                process.kill()
        await process.wait()
        # A child of the app that still runs may keep its pipes open.
        await asyncio.wait([task], timeout=1)
        task.cancel()


def _decode(text: str) -> object:
    try:
        decoded: object = json.loads(text)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    return decoded
