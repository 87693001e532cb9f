"""The terminal UI in a browser: a server on top of textual-serve's.

It serves a page that loads nothing from elsewhere, and takes a connection only from its own
page: any other site that a browser shows could else open one and steer the app.
"""

import ipaddress
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import aiohttp_jinja2
from aiohttp import web
from aiohttp.typedefs import Handler, Middleware
from textual_serve.server import Server, to_int

from gaitsim.errors import GaitsimError

PAGE = Path(__file__).parent / "page"
LOCAL = "localhost"


class WebServer(Server):
    """Runs a command that is a Textual app for each page that is opened.

    Args:
        command: as a shell takes it.
        host: the address it listens on.
        port: the port it listens on.
        title: of the page.
    """

    def __init__(self, command: str, host: str, port: int, title: str) -> None:
        super().__init__(command, host=host, port=port, title=title, templates_path=PAGE)

    def serve_on(self, listener: socket.socket) -> None:
        """Serve until Ctrl-C."""
        self.port = listener.getsockname()[1]
        web.run_app(self._make_app(), sock=listener, print=None, shutdown_timeout=5)

    async def _make_app(self) -> web.Application:
        app = await super()._make_app()
        app.middlewares.append(self._guard())
        return app

    def _guard(self) -> Middleware:
        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            """Refuse what does not come from this server's own page, by its own name."""
            if not (self._is_ours(request.host) and _same(request.headers.get("Origin"), request)):
                raise web.HTTPForbidden(text="gaitsim serves its own page alone.")
            return await handler(request)

        return guard

    def _is_ours(self, host: str) -> bool:
        """Whether a name is one of this machine; where all may come, any name may be."""
        return not is_loopback(self.host) or is_loopback(urlsplit(f"//{host}").hostname or "")

    async def on_startup(self, app: web.Application) -> None:
        """Say where it is."""
        shown = f"[{self.host}]" if ":" in self.host else self.host
        print(f"gaitsim is at http://{shown}:{self.port}; Ctrl-C stops it", flush=True)  # noqa: T201

    @aiohttp_jinja2.template("app_index.html")
    async def handle_index(self, request: web.Request) -> dict[str, Any]:
        """What the page is filled with; addresses are relative to the one that it was asked by."""
        scheme = "wss" if request.scheme == "https" else "ws"
        return {
            "font_size": to_int(request.query.get("fontsize", "16"), 16),
            "app_websocket_url": f"{scheme}://{request.host}/ws",
            "config": {"static": {"url": "/static/"}},
            "application": {"name": self.title},
        }


def _same(origin: str | None, request: web.Request) -> bool:
    """Whether a request that names the page it comes from comes from ours."""
    return origin is None or urlsplit(origin).netloc == request.host


def is_loopback(host: str) -> bool:
    """Whether an address is this machine's alone."""
    try:
        return host == LOCAL or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@contextmanager
def listening(host: str, port: int) -> Iterator[socket.socket]:
    """A socket that listens there.

    Raises:
        GaitsimError: there is no such address, or the port is taken.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise GaitsimError(
            f"cannot listen on {host}, port {port}: {reason}",
            allowed="an address of this machine, such as 127.0.0.1, and a port that is free",
            remedy=f"try another one, as --port {port + 1 if port < 65535 else 8000}",
        ) from None
    with listener:
        yield listener
