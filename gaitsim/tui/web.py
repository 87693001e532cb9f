"""The terminal UI in a browser: a server on top of textual-serve's.

It serves a page that loads nothing from elsewhere, and takes a connection only from its own
page: any other site that a browser shows could else open one and steer the app.
"""

import ipaddress
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from pathlib import Path
from string import Template
from urllib.parse import urlsplit

from aiohttp import web
from aiohttp.typedefs import Handler
from textual_serve.server import Server, to_int

from gaitsim.errors import GaitsimError

PAGE = Path(__file__).parent / "page.html"
LOCAL = "localhost"


class WebServer(Server):
    """Runs a command, which starts a Textual app, for each page that is opened."""

    def serve_on(self, listener: socket.socket) -> None:
        """Serve until Ctrl-C."""
        self.port = listener.getsockname()[1]
        web.run_app(self.application(), sock=listener, print=None, shutdown_timeout=5)

    def application(self) -> web.Application:
        """Return the server's pages."""
        app = web.Application(middlewares=[self._guard])
        app.add_routes(
            [
                web.get("/", self.page),
                web.get("/ws", self.handle_websocket),
                web.get("/download/{key}", self.handle_download),
                web.static("/static", self.statics_path),
            ]
        )
        app.on_startup.append(self.on_startup)
        app.on_shutdown.append(self.on_shutdown)
        return app

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse requests that do not come from this server's own page, by its own name."""
        if not (self._is_ours(request.host) and _same(request.headers.get("Origin"), request)):
            raise web.HTTPForbidden(text="gaitsim serves its own page alone.")
        return await handler(request)

    def _is_ours(self, host: str) -> bool:
        """Return whether a host name is ours; any name is, unless only this machine may connect."""
        return not is_loopback(self.host) or is_loopback(urlsplit(f"//{host}").hostname or "")

    async def on_startup(self, app: web.Application) -> None:
        """Print the address."""
        shown = f"[{self.host}]" if ":" in self.host else self.host
        print(f"gaitsim is at http://{shown}:{self.port}; Ctrl-C stops it", flush=True)  # noqa: T201

    async def page(self, request: web.Request) -> web.Response:
        """Return the page, filled for the address that it was asked by."""
        scheme = "wss" if request.scheme == "https" else "ws"
        values = {
            "title": self.title,
            "websocket": f"{scheme}://{request.host}/ws",
            "font_size": str(to_int(request.query.get("fontsize", "16"), 16)),
        }
        filled = Template(PAGE.read_text(encoding="utf-8")).substitute(
            {name: escape(value) for name, value in values.items()}
        )
        return web.Response(text=filled, content_type="text/html")


def _same(origin: str | None, request: web.Request) -> bool:
    """Return whether a request comes from our page, if it names its page."""
    return origin is None or urlsplit(origin).netloc == request.host


def is_loopback(host: str) -> bool:
    """Return whether an address is reachable only from this machine."""
    try:
        return host == LOCAL or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@contextmanager
def listening(host: str, port: int) -> Iterator[socket.socket]:
    """Open a socket that listens on an address.

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
