"""The terminal UI in a browser: a server on top of textual-serve's.

It serves a page without external resources, to clients that know its token. It accepts
connections only from that page, so that no other site in the browser can control the app.
"""

import asyncio
import errno
import ipaddress
import json
import secrets
import shlex
import socket
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from html import escape
from pathlib import Path
from string import Template
from urllib.parse import quote, urlsplit
from weakref import WeakSet

from aiohttp import WSCloseCode, WSMsgType, web
from aiohttp.typedefs import Handler
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager
from textual_serve.server import Server, to_int

from gaitsim.plugin import GaitsimError, read_regular

MOST_COLUMNS = 500
MOST_ROWS = 200
FAILED = b"The app has failed. See the reason in the terminal of gaitsim serve."
GRACE = 15.0  # seconds to wait for an app to end; an app allows itself less
PAGE = Path(__file__).parent / "page.html"
LOCAL = "localhost"
WINDOWS = 8
LONGEST_MESSAGE = 1 << 20  # bytes; a paste arrives as one message
PATIENCE = 5.0  # seconds to wait for another app to end, such as after a reload
DEADLINE = 10.0  # seconds in which a connection must send its first request
MOST_WAITING = 64  # connections that have not sent a request yet
SLOWED = 1.0  # seconds that a wrong token takes
MOST_SLOWED = 16  # wrong tokens at a time; more are refused at once

# For pages that refuse access, with text and a form. The app's page needs more.
PLAIN_POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'"
HEADERS = {
    "Content-Security-Policy": PLAIN_POLICY,
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
POLICY = (
    "default-src 'none'; script-src 'self' 'nonce-{nonce}'; style-src 'self' 'unsafe-inline'; "
    "font-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# The scripts of an exported page run in an opaque origin, so that they reach neither the app at the
# same address nor the network. The page's own policy allows only the viewer's scripts.
PUBLISHED_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
MOST_PUBLISHED = 100  # pages; the oldest are dropped
LARGEST_PUBLISHED = 1 << 27  # bytes
NO_TOKEN = Template("""<!DOCTYPE html>
<html lang="en">
  <meta charset="utf-8" /><title>gaitsim</title>
  <body style="font: 16px monospace; margin: 3em; background: #0f151b; color: #d7dee6">
    <p>$hint Open the address printed by gaitsim serve, or enter its token:</p>
    <form><input name="token" type="password" autofocus /> <button>Open</button></form>
  </body>
</html>
""")


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
        environment["TEXTUAL_DRIVER"] = "gaitsim_serve.driver:PipeDriver"
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


class WebServer(Server):
    """A server that runs a command, which starts a Textual app, for each open page.

    Args:
        command: command line of the app.
        host: address to listen on.
        token: secret that opens the page; a cookie replaces it afterwards.
        windows: maximum number of apps that run at a time.
    """

    def __init__(self, command: str, host: str, token: str, windows: int = WINDOWS) -> None:
        super().__init__(command, host, title="gaitsim")
        self._token = token
        self._cookie = (
            secrets.token_urlsafe()
        )  # not the token, because browsers also send cookies to other ports
        self._windows = windows
        self._free = asyncio.Semaphore(windows)
        self._published: dict[str, Path] = {}
        self._open: WeakSet[web.WebSocketResponse] = WeakSet()
        self._ending: set[asyncio.Task[None]] = set()
        self._waiting: dict[asyncio.Transport, asyncio.TimerHandle] = {}
        self._slowed = 0

    def serve_on(self, listener: socket.socket) -> None:
        """Serve until Ctrl-C."""
        self.port = listener.getsockname()[1]
        with suppress(KeyboardInterrupt, web.GracefulExit):
            asyncio.run(self._serve(listener))

    async def _serve(self, listener: socket.socket) -> None:
        runner = web.AppRunner(
            self.application(), handle_signals=True, access_log=None, shutdown_timeout=20
        )
        await runner.setup()
        loop = asyncio.get_running_loop()
        handlers = runner.server
        assert handlers is not None
        # asyncio accepts as many connections as the backlog allows before it admits the first.
        listening = await loop.create_server(
            lambda: _Door(self, handlers), sock=listener, backlog=_most_waiting()
        )
        try:
            await loop.create_future()  # until a signal raises an error
        finally:
            listening.close()
            await runner.cleanup()

    def admit(self, transport: asyncio.Transport) -> None:
        """Give a new connection a deadline for its request, and the place of the oldest one.

        Connections that send nothing would otherwise use up all file descriptors.
        """
        while len(self._waiting) >= _most_waiting():
            self._dismiss(next(iter(self._waiting)))
        loop = asyncio.get_running_loop()
        self._waiting[transport] = loop.call_later(DEADLINE, self._dismiss, transport)

    def _dismiss(self, transport: asyncio.Transport) -> None:
        self._waiting.pop(transport).cancel()
        transport.abort()

    def application(self) -> web.Application:
        """Return the web application with its routes."""
        app = web.Application(middlewares=[self._guard])
        app.add_routes(
            [
                web.get("/", self.page),
                web.get("/ws", self.handle_websocket),
                web.get("/download/{key}", self.handle_download),
                web.get("/pages/{key}", self.handle_published),
                web.static("/static", self.statics_path),
            ]
        )
        app.on_response_prepare.append(_protect)
        app.on_startup.append(self.on_startup)
        app.on_shutdown.append(self.on_shutdown)
        app.on_cleanup.append(self._on_cleanup)
        return app

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse requests without the token, and requests from pages of other sites."""
        if isinstance(request.transport, asyncio.Transport) and request.transport in self._waiting:
            self._waiting.pop(request.transport).cancel()
        if not (self._is_own_host(request) and _same_origin(request)):
            raise _forbidden("gaitsim accepts requests only from its own page.")
        cookie = f"gaitsim-{_port(request)}"
        token = request.query.get("token")
        if request.path == "/" and token and _equal(token, self._token):
            rest = request.rel_url.without_query_params("token").raw_query_string
            page = web.HTTPSeeOther(f"/?{rest}" if rest else "/")
            page.set_cookie(cookie, self._cookie, httponly=True, samesite="Strict")
            raise page
        if not _equal(request.cookies.get(cookie, ""), self._cookie):
            hint = "This token is not valid." if token else ""
            if token:
                await self._slow_down()
            raise _forbidden(NO_TOKEN.substitute(hint=hint), "text/html")
        return await handler(request)

    async def _slow_down(self) -> None:
        """Wait, so that tokens cannot be guessed quickly."""
        if self._slowed >= MOST_SLOWED:
            raise web.HTTPTooManyRequests(text="Too many wrong tokens. Try again in a second.")
        self._slowed += 1
        try:
            await asyncio.sleep(SLOWED)
        finally:
            self._slowed -= 1

    def _is_own_host(self, request: web.Request) -> bool:
        """Return whether a request names this host; a public address accepts any name."""
        return not is_loopback(self.host) or is_loopback(_host(f"//{request.host}"))

    async def on_startup(self, app: web.Application) -> None:
        """Print the address with the token."""
        any_address = self.host in ("0.0.0.0", "::")
        host = socket.gethostname() if any_address else self.host
        shown = f"[{host}]" if ":" in host else host
        address = f"http://{shown}:{self.port}/?token={quote(self._token, safe='')}"
        print(f"gaitsim is running at {address}\nPress Ctrl-C to stop", flush=True)  # noqa: T201

    async def on_shutdown(self, app: web.Application) -> None:
        """Close the windows, which ends their apps."""
        await asyncio.gather(*map(_close_window, self._open))

    async def _on_cleanup(self, app: web.Application) -> None:
        await asyncio.gather(*self._ending)

    async def page(self, request: web.Request) -> web.Response:
        """Return the app's page, filled in for the requested address."""
        scheme = "wss" if request.scheme == "https" else "ws"
        values = {
            "title": self.title,
            "nonce": secrets.token_urlsafe(),
            "websocket": f"{scheme}://{request.host}/ws",
            "font_size": str(min(max(to_int(request.query.get("fontsize", "16"), 16), 6), 72)),
        }
        filled = Template(PAGE.read_text(encoding="utf-8")).substitute(
            {name: escape(value) for name, value in values.items()}
        )
        policy = {"Content-Security-Policy": POLICY.format(nonce=values["nonce"])}
        return web.Response(text=filled, content_type="text/html", headers=policy)

    def publish(self, path: Path) -> str:
        """Serve a page that an app has exported; return its address on this server."""
        key = secrets.token_urlsafe()
        self._published[key] = path
        for oldest in [*self._published][:-MOST_PUBLISHED]:
            del self._published[oldest]
        return f"/pages/{key}"

    async def handle_published(self, request: web.Request) -> web.Response:
        """Return a page that an app has exported, with a policy that isolates it."""
        path = self._published.get(request.match_info["key"])
        if path is None:
            raise web.HTTPNotFound(
                text="This page is no longer served. Open it again from the app."
            )
        try:
            page = await asyncio.to_thread(read_regular, path, LARGEST_PUBLISHED)
        except OSError as error:
            raise web.HTTPNotFound(text=f"The page cannot be read: {error.strerror}") from None
        policy = {"Content-Security-Policy": PUBLISHED_POLICY, "Cache-Control": "no-store"}
        return web.Response(body=page, content_type="text/html", charset="utf-8", headers=policy)

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """Run an app for a page until the app ends or the page closes."""
        if "Origin" not in request.headers:
            raise web.HTTPForbidden(text="gaitsim accepts connections only from its own page.")
        websocket = web.WebSocketResponse(heartbeat=15, max_msg_size=LONGEST_MESSAGE)
        await websocket.prepare(request)
        try:
            async with asyncio.timeout(PATIENCE):
                await self._free.acquire()
        except TimeoutError:
            reason = f"{self._windows} windows are open; --windows sets the maximum."
            await websocket.close(code=WSCloseCode.TRY_AGAIN_LATER, message=reason.encode())
            return websocket
        self._open.add(websocket)
        app = ServedApp(self.command, websocket, self.download_manager, self.publish)
        width, height = (to_int(request.query.get(name, ""), 80) for name in ("width", "height"))
        try:
            await app.start(*limit_size(width, height))
            await _forward_messages(websocket, app)
        finally:
            # End the app even if the request was cancelled.
            ending = asyncio.create_task(self._end(app))
            self._ending.add(ending)
            ending.add_done_callback(self._ending.discard)
            await asyncio.shield(ending)
        return websocket

    async def _end(self, app: ServedApp) -> None:
        try:
            await app.stop()
        finally:
            self._free.release()


class _Door(asyncio.Protocol):
    """A connection that the server admits before aiohttp serves it."""

    def __init__(self, server: WebServer, handlers: Callable[[], asyncio.BaseProtocol]) -> None:
        self._server, self._handlers = server, handlers

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._server.admit(transport)
        handler = self._handlers()
        transport.set_protocol(handler)
        handler.connection_made(transport)


def _most_waiting() -> int:
    """Return the allowed number of waiting connections, a quarter of all file descriptors."""
    if sys.platform == "win32":
        return MOST_WAITING
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MOST_WAITING if soft < 0 else max(1, min(MOST_WAITING, soft // 4))


def _forbidden(text: str, kind: str = "text/plain") -> web.HTTPForbidden:
    """Return a refusal that also closes the connection, which would keep a descriptor."""
    refusal = web.HTTPForbidden(text=text, content_type=kind)
    refusal.force_close()
    return refusal


async def _forward_messages(websocket: web.WebSocketResponse, app: ServedApp) -> None:
    """Forward a page's messages to its app until it disconnects or a message is malformed."""
    async for message in websocket:
        try:
            if message.type is not WSMsgType.TEXT:
                raise ValueError("not a text message")
            await app.handle_message(message.data)
        except ValueError:
            await websocket.close(
                code=WSCloseCode.POLICY_VIOLATION, message=b"The page sent a malformed message."
            )
            return


async def _close_window(websocket: web.WebSocketResponse) -> None:
    await websocket.close(code=WSCloseCode.GOING_AWAY, message=b"gaitsim serve has ended.")


async def _protect(request: web.Request, response: web.StreamResponse) -> None:
    """Set headers that prevent framing and hide the address from other sites."""
    for name, value in HEADERS.items():
        response.headers.setdefault(name, value)


def _same_origin(request: web.Request) -> bool:
    """Return whether a request comes from our page, or does not name its origin."""
    origin = request.headers.get("Origin")
    return origin is None or origin.partition("://")[2] == request.host


def _host(url: str) -> str:
    try:
        return urlsplit(url).hostname or ""
    except ValueError:
        return ""


def _port(request: web.Request) -> str:
    """Return the port in the browser's address, which a tunnel may change."""
    port = request.host.rpartition(":")[2]
    return port if port.isdecimal() and port.isascii() else "80"


def _equal(given: str, secret: str) -> bool:
    """Return whether two strings are equal, in constant time."""
    return secrets.compare_digest(given.encode("utf-8", "replace"), secret.encode())


def is_loopback(host: str) -> bool:
    """Return whether an address is reachable only from this machine."""
    try:
        return host == LOCAL or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@contextmanager
def listening_socket(host: str, port: int) -> Iterator[socket.socket]:
    """Open a socket that listens on an address."""
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        number = error.errno if isinstance(error, OSError) else None
        # Python appends the address, which the message already contains.
        reason = getattr(error, "strerror", None) or str(error)
        port_is_wrong = number in (errno.EADDRINUSE, errno.EACCES)
        raise GaitsimError(
            f"cannot listen on {host}, port {port}: {reason.partition(' (while')[0]}",
            allowed="an address of this machine, such as 127.0.0.1, and a free port",
            remedy=f"try another port, such as --port {port + 1 if port < 65535 else 8000}"
            if port_is_wrong
            else "omit --host to listen only on this machine",
        ) from None
    with listener:
        yield listener
