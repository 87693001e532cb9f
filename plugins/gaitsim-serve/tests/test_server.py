"""The UI in a browser: access by token from its own page only, and apps that end with windows."""

import asyncio
import json
import os
import shlex
import socket
import subprocess
import sys
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from aiohttp import ClientSession, CookieJar, WSMsgType, WSServerHandshakeError
from aiohttp.test_utils import TestClient, TestServer
from waiting import until

from gaitsim_serve import server
from gaitsim_serve.server import LONGEST_MESSAGE, PAGE, WebServer, is_loopback

TOKEN = "a token & more"
# An app that writes its size, process ID and token, then echoes its input.
ECHO = """
import os
def write(data):
    os.write(1, b"D" + len(data).to_bytes(4, "big") + data)
os.write(1, b"__GANGLION__\\n")
names = ("COLUMNS", "ROWS", "GAITSIM_TOKEN")
write(repr([os.getpid(), *map(os.environ.get, names)]).encode())
while data := os.read(0, 1 << 20):
    write(data)
"""
DEAF = f"{ECHO}\n__import__('time').sleep(1000)"  # neither a message nor a closed pipe ends it
LOUD = ECHO.replace("    write(data)", "    [write(bytes(100_000)) for _ in range(100)]")


@pytest.fixture(autouse=True)
def prompt(monkeypatch):
    """Refuse wrong tokens at once."""
    monkeypatch.setattr(server, "SLOWED", 0.0)


@pytest.fixture
def free_port():
    """Return a free port."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


@asynccontextmanager
async def serving(script="", *, host="127.0.0.1", token=TOKEN, windows=8, **headers):
    """A client that has sent its token to a server whose app is a script."""
    app = shlex.join([sys.executable, "-c", script])
    there = TestServer(WebServer(app, host, TOKEN, windows).application())
    async with TestClient(there, cookie_jar=CookieJar(unsafe=True)) as client:
        if token:
            shown = {"token": token}
            await client.get("/", params=shown, headers=headers, allow_redirects=False)
        yield client


def ask(path, host="127.0.0.1", token=TOKEN, **headers):
    """Return the response of a server that listens on `host`, and its text."""

    async def go():
        async with serving(host=host, token=token, **headers) as client:
            found = await client.get(path, headers=headers, allow_redirects=False)
            return found, await found.text()

    return asyncio.run(go())


class TestGuard:
    def test_the_page_is_complete_and_loads_no_external_resources(self):
        found, text = ask("/?fontsize=1000000", Host="127.0.0.1:8000")
        assert found.status == 200
        assert 'data-session-websocket-url="ws://127.0.0.1:8000/ws"' in text
        assert 'data-font-size="72"' in text
        assert "$nonce" not in text
        for place in ("href=", "src=", "url("):
            for part in text.split(place)[1:]:
                assert part.strip("\"'").startswith(("/static/", "data:")), part[:60]
        assert PAGE.is_file()

    @pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:1", "[::1]:8000", "127.0.0.1"])
    def test_names_of_this_machine_are_accepted(self, host):
        assert ask("/", Host=host)[0].status == 200

    @pytest.mark.parametrize(
        "host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "[::1", "::1"]
    )
    def test_foreign_names_are_refused(self, host):
        assert ask("/", Host=host)[0].status == 403

    def test_a_public_address_accepts_any_name(self):
        assert ask("/", host="0.0.0.0", Host="lab.example:8000")[0].status == 200

    @pytest.mark.parametrize("path", ["/", "/ws", "/static/js/textual.js"])
    @pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:8001", "null"])
    def test_another_sites_page_is_refused(self, path, origin):
        headers = {"Host": "127.0.0.1:8000"}
        for host in ("127.0.0.1", "0.0.0.0"):

            async def go(host=host):
                async with serving(host=host, **headers) as client:
                    more = headers | {"Origin": origin}
                    return (await client.get(path, headers=more)).status

            assert asyncio.run(go()) == 403

    @pytest.mark.parametrize("origin", [None, "http://evil.example", "http://127.0.0.1:1"])
    async def test_an_app_requires_the_origin_of_the_page(self, origin):
        async with serving() as client:
            with pytest.raises(WSServerHandshakeError) as refused:
                await client.ws_connect("/ws", origin=origin)
            assert refused.value.status == 403

    @pytest.mark.parametrize(
        "path", ["/", "/?fontsize=20", "/static/js/textual.js", "/download/x", "/nothing"]
    )
    @pytest.mark.parametrize("token", ["", "wrong", "é", TOKEN])
    def test_every_response_forbids_frames_and_referrers(self, path, token):
        headers = ask(path, token=token)[0].headers
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["X-Frame-Options"] == "DENY"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"


class TestToken:
    @pytest.mark.parametrize("token", ["", "wrong", "é", TOKEN[:-1], f"{TOKEN} "])
    @pytest.mark.parametrize("path", ["/", "/ws", "/static/js/textual.js", "/download/x"])
    def test_every_path_requires_the_token(self, path, token):
        found, text = ask(path, token=token)
        assert found.status == 403
        assert "printed by gaitsim serve" in text

    async def test_an_app_requires_the_token(self):
        async with serving(token="") as client:
            with pytest.raises(WSServerHandshakeError) as refused:
                await client.ws_connect("/ws", origin=str(client.make_url("")).rstrip("/"))
            assert refused.value.status == 403

    def test_a_cookie_replaces_the_token_in_the_address(self):
        found, _ = ask("/?token=a+token+%26+more&fontsize=20", token="")
        assert (found.status, found.headers["Location"]) == (303, "/?fontsize=20")
        cookie = next(iter(found.cookies.values()))
        assert (
            cookie.key == f"gaitsim-{found.url.port}"
        )  # other servers on this machine have other cookies
        assert (cookie["httponly"], cookie["samesite"]) == (True, "Strict")
        assert TOKEN not in cookie.value

    def test_behind_a_tunnel_the_cookie_has_the_browsers_port(self):
        found, _ = ask("/?token=a+token+%26+more", token="", Host="localhost:9000")
        assert list(found.cookies) == ["gaitsim-9000"]

    @pytest.mark.parametrize("empty", ["", " "])
    def test_an_empty_token_is_rejected(self, gaitsim, monkeypatch, empty):
        Path("token.txt").write_text(empty)
        answer = gaitsim("serve", "--token-file", "token.txt", code=2).stderr
        assert "the token is empty" in answer
        assert "token.txt" in answer
        monkeypatch.setenv("GAITSIM_TOKEN", empty)
        assert "the token is empty" in gaitsim("serve", code=2).stderr

    @pytest.mark.parametrize("content", [None, b"\xff"])
    def test_a_token_that_cannot_be_read_is_a_user_error(self, gaitsim, content):
        if content is not None:
            Path("token.txt").write_bytes(content)
        answer = gaitsim("serve", "--token-file", "token.txt", code=2).stderr
        assert "cannot read the token" in answer

    async def test_wrong_tokens_wait_for_one_another(self, monkeypatch):
        monkeypatch.setattr(server, "SLOWED", 0.5)
        async with serving(token="") as client:
            tries = [client.get("/", params={"token": str(at)}) for at in range(40)]
            found = [one.status for one in await asyncio.gather(*tries)]
            assert found.count(429) == 40 - server.MOST_SLOWED
            right = await client.get("/", params={"token": TOKEN}, allow_redirects=False)
            assert right.status == 303

    def test_by_default_each_server_has_its_own_token(self, gaitsim, monkeypatch, free_port):
        seen = served(monkeypatch)
        gaitsim("serve", "--port", free_port)
        gaitsim("serve", "--port", free_port)
        monkeypatch.setenv("GAITSIM_TOKEN", "mine")
        gaitsim("serve", "--port", free_port)
        Path("token.txt").write_text("from a file\n")
        gaitsim("serve", "--port", free_port, "--token-file", "token.txt")
        first, second, third, fourth = (server._token for server in seen)
        assert fourth == "from a file"
        assert first != second
        assert min(len(first), len(second)) >= 32
        assert third == "mine"
        assert "mine" not in seen[2].command


class TestDoor:
    """Connections that send half a request, which need no token."""

    @asynccontextmanager
    async def listening(self, script=""):
        with server.listening_socket("127.0.0.1", 0) as listener:
            app = shlex.join([sys.executable, "-c", script])
            serving = WebServer(app, "127.0.0.1", TOKEN)
            serving.port = listener.getsockname()[1]
            running = asyncio.create_task(serving._serve(listener))
            yield f"http://127.0.0.1:{serving.port}/"
            running.cancel()
            await asyncio.wait([running])

    async def half(self, address):
        """Send half a request."""
        reader, writer = await asyncio.open_connection("127.0.0.1", urlsplit(address).port)
        writer.write(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        return reader, writer

    async def test_many_leave_room_for_others(self, monkeypatch):
        monkeypatch.setattr(server, "MOST_WAITING", 8)
        async with self.listening() as address:
            halves = [await self.half(address) for _ in range(20)]
            async with ClientSession() as session:
                found = await session.get(address, params={"token": TOKEN}, allow_redirects=False)
                assert found.status == 303
            # The oldest ones have made room; the latest still wait.
            for reader, _ in halves[:12]:
                with suppress(ConnectionResetError):
                    assert await reader.read() == b""
            assert not halves[-1][0].at_eof()
            for _, writer in halves:
                writer.close()

    async def test_each_has_a_deadline(self, monkeypatch):
        monkeypatch.setattr(server, "DEADLINE", 0.1)
        async with self.listening() as address:
            reader, writer = await self.half(address)
            with suppress(ConnectionResetError):
                assert await reader.read() == b""
            writer.close()

    async def test_a_refused_request_closes_its_connection(self):
        async with self.listening() as address:
            reader, writer = await self.half(address)
            writer.write(b"\r\n")
            assert b" 403 " in await reader.readline()
            await reader.read()  # ends
            writer.close()

    async def test_two_users_have_an_app_each(self):
        async with self.listening(ECHO) as address:
            apps = []
            for _ in range(2):
                session = ClientSession(cookie_jar=CookieJar(unsafe=True))
                await session.get(address, params={"token": TOKEN})
                connection = await session.ws_connect(f"{address}ws", origin=address.rstrip("/"))
                pid = eval(await connection.receive_bytes())[0]
                apps.append((session, connection, pid))
            assert apps[0][2] != apps[1][2]
            for session, connection, _ in apps:
                await connection.close()
                await session.close()


async def window(client, query=""):
    """Open an app; return its connection and its first output."""
    origin = str(client.make_url("")).rstrip("/")
    connection = await client.ws_connect(f"/ws{query}", origin=origin)
    return connection, eval(await connection.receive_bytes())


def ended(process):
    """Return whether a process has ended."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


class TestApps:
    async def test_its_size_is_limited_and_the_token_is_hidden_from_it(self, monkeypatch):
        monkeypatch.setenv("GAITSIM_TOKEN", TOKEN)
        async with serving(ECHO) as client:
            large, (_, *first) = await window(client, "?width=1000000000&height=-5")
            assert first == ["500", "1", None]
            await large.send_json(["resize", {"width": 10**9, "height": 10**9}])
            assert b'"width": 500, "height": 200' in await large.receive_bytes()
            await large.send_json(["ping", "1"])
            assert await large.receive_json() == ["pong", "1"]
            await large.send_json(["stdin", "d\ud800"])
            assert (await large.receive_bytes()).endswith(b"d?")

    @pytest.mark.parametrize(
        "bad",
        [
            "",
            "{",
            "[]",
            '["stdin", 1]',
            '["resize", {"width": "80", "height": 24}]',
            '["resize", {"width": 1e9, "height": 24}]',
            '["quit"]',
            "[" * 100_000,
            f"[{'1' * 5000}]",
            b"bytes",
            json.dumps(["stdin", "x" * LONGEST_MESSAGE]),
        ],
        ids=lambda bad: str(bad[:20]),
    )
    async def test_a_malformed_message_ends_its_connection_quietly(self, bad, caplog):
        async with serving(ECHO) as client:
            connection, (process, *_) = await window(client)
            send = connection.send_bytes if isinstance(bad, bytes) else connection.send_str
            await send(bad)
            last = await connection.receive()
            assert last.type is WSMsgType.CLOSE
        until(lambda: ended(process))
        assert not caplog.records

    @pytest.mark.parametrize("script", [ECHO, DEAF, LOUD], ids=["echo", "deaf", "loud"])
    async def test_it_ends_with_its_window(self, script, monkeypatch):
        monkeypatch.setattr(server, "GRACE", 0.5)
        async with serving(script) as client:
            connection, (process, *_) = await window(client)
            await connection.send_json(["stdin", "x"])
            await connection.close()
            async with asyncio.timeout(30):
                while not ended(process):
                    await asyncio.sleep(0.02)

    async def test_an_excess_window_waits_for_another_to_close_or_is_refused(self, monkeypatch):
        monkeypatch.setattr(server, "PATIENCE", 0.2)
        async with serving(ECHO, windows=1) as client:
            first, _ = await window(client)
            origin = str(client.make_url("")).rstrip("/")
            second = await client.ws_connect("/ws", origin=origin)
            assert "windows are open" in (await second.receive()).extra
            monkeypatch.setattr(server, "PATIENCE", 30)
            await first.close()
            await window(client)

    def test_a_failed_app_refers_to_the_terminal(self, capfd):
        async def go():
            async with serving("import sys; sys.exit('broken')") as client:
                origin = str(client.make_url("")).rstrip("/")
                connection = await client.ws_connect("/ws", origin=origin)
                return (await connection.receive()).extra

        assert "terminal" in asyncio.run(go())
        assert "broken" in capfd.readouterr().out

    def test_it_ends_with_its_server(self, start):
        environment = os.environ | {"TEXTUAL_DRIVER": "gaitsim_serve.driver:PipeDriver"}
        app = start("tui", env=environment, stdin=subprocess.PIPE, text=False)
        assert app.stdout.readline() == b"__GANGLION__\n"
        os.set_blocking(app.stdout.fileno(), False)
        drawn = bytearray()

        def drew_home():
            drawn.extend(app.stdout.read1())
            return b"There are no runs" in drawn

        until(drew_home)
        app.stdin.close()
        app.stdout.close()
        assert app.wait(30) == 0


def meta(**content):
    """Return the script of an app that sends the server a request, then echoes its input."""
    asked = json.dumps(content).encode()
    packet = b"M" + len(asked).to_bytes(4, "big") + asked
    return ECHO.replace("while data", f"os.write(1, {packet!r})\nwhile data")


class TestPages:
    def show(self, path):
        """Return the response of a server to a request for a page that its app has exported."""

        async def go():
            async with serving(meta(type="page", path=str(path))) as client:
                connection, _ = await window(client)
                what, address = await connection.receive_json()
                assert what == "page"
                assert address.startswith("/pages/")
                found = await client.get(address)
                return found, await found.read()

        return asyncio.run(go())

    def test_a_page_is_isolated_from_the_app(self, tmp_path):
        (tmp_path / "a.html").write_text("<p>ö", encoding="utf-8")
        found, page = self.show(tmp_path / "a.html")
        assert (found.status, found.content_type, found.charset) == (200, "text/html", "utf-8")
        assert page == "<p>ö".encode()
        policy = found.headers["Content-Security-Policy"].split("; ")
        assert "sandbox allow-scripts" in policy  # its own origin, without the cookie
        assert "default-src 'none'" in policy
        assert found.headers["X-Frame-Options"] == "DENY"
        assert found.headers["X-Content-Type-Options"] == "nosniff"

    def test_other_files_are_not_served(self, tmp_path):
        (tmp_path / "link.html").symlink_to("/etc/passwd")
        for path in (tmp_path / "missing.html", tmp_path, tmp_path / "link.html"):
            found, page = self.show(path)
            assert found.status == 404
            assert b"root" not in page
        assert ask("/pages/x")[0].status == 404
        assert ask("/pages/x", token="")[0].status == 403


def served(monkeypatch):
    """Return a list that receives the servers instead of running them."""
    seen = []
    monkeypatch.setattr(WebServer, "serve_on", lambda server, _: seen.append(server))
    return seen


class TestListening:
    @pytest.mark.parametrize(
        ("host", "loopback"),
        [
            ("127.0.0.1", True),
            ("127.9.9.9", True),
            ("::1", True),
            ("localhost", True),
            ("0.0.0.0", False),
            ("::", False),
            ("192.168.0.7", False),
            ("lab.example", False),
        ],
    )
    def test_loopback_addresses_are_recognised(self, host, loopback):
        assert is_loopback(host) is loopback

    def test_a_port_in_use_is_reported(self, gaitsim):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            stderr = gaitsim("serve", "--port", port, code=2).stderr
        assert f"cannot listen on 127.0.0.1, port {port}" in stderr
        assert "--port" in stderr

    @pytest.mark.parametrize(
        "bad",
        [
            ["--host", "nowhere.invalid"],
            ["--host", "300.1.1.1"],
            ["--port", "70000"],
            ["--theme", "gaitsim-lite"],
            ["--windows", "0"],
        ],
    )
    def test_invalid_options_are_reported(self, gaitsim, bad):
        assert "Traceback" not in gaitsim("serve", *bad, code=2).stderr

    def test_a_public_address_prints_a_warning(self, gaitsim, monkeypatch, free_port):
        served(monkeypatch)
        assert "ssh -L" in gaitsim("serve", "--host", "0.0.0.0", "--port", free_port).stderr
        assert gaitsim("serve", "--port", free_port).stderr == ""

    def test_the_app_gets_its_folder_and_theme(self, monkeypatch, gaitsim, free_port):
        seen = served(monkeypatch)
        gaitsim("serve", "my runs", "--port", free_port, "--theme", "nord")
        assert seen[0].command.endswith("-m gaitsim tui 'my runs' --theme nord")
