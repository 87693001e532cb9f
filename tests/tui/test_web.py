"""The UI in a browser: on this machine alone, from its own page alone; a run that progresses."""

import asyncio
import os
import shutil
import socket
import sys
from pathlib import Path

import pytest
from aiohttp import ClientSession, WSServerHandshakeError
from aiohttp.test_utils import TestClient, TestServer

from gaitsim.tui.web import PAGE, WebServer, is_loopback, listening

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture
def free():
    """A port that is free."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


def ask(path, host="127.0.0.1", **headers):
    """Status and text of a page of a server that listens on `host`."""

    async def go():
        server = WebServer("true", host, 0, "gaitsim")
        async with TestClient(TestServer(server.application())) as client:
            found = await client.get(path, headers=headers)
            return found.status, await found.text()

    return asyncio.run(go())


class TestGuard:
    def test_the_page_is_whole_and_loads_nothing_from_elsewhere(self):
        status, text = ask("/", Host="127.0.0.1:8000")
        assert status == 200
        assert 'data-session-websocket-url="ws://127.0.0.1:8000/ws"' in text
        assert "$" not in text
        for place in ("href=", "src=", "url("):
            for part in text.split(place)[1:]:
                assert part.strip("\"'").startswith(("/static/", "data:")), part[:60]
        assert PAGE.is_file()

    @pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:1", "[::1]:8000", "127.0.0.1"])
    def test_names_of_this_machine(self, host):
        assert ask("/", Host=host)[0] == 200

    @pytest.mark.parametrize(
        "host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example"]
    )
    def test_a_name_that_leads_here_by_a_trick_is_refused(self, host):
        assert ask("/", Host=host)[0] == 403

    def test_where_all_may_come_any_name_may_be(self):
        assert ask("/", host="0.0.0.0", Host="lab.example:8000")[0] == 200

    @pytest.mark.parametrize("path", ["/", "/ws", "/static/js/textual.js"])
    def test_another_sites_page_is_refused(self, path):
        headers = {"Host": "127.0.0.1:8000", "Origin": "http://evil.example"}
        assert ask(path, **headers)[0] == 403
        assert ask(path, host="0.0.0.0", **headers)[0] == 403

    def test_another_sites_page_gets_no_app(self):
        async def go():
            server = WebServer("true", "127.0.0.1", 0, "gaitsim")
            async with TestServer(server.application()) as there, ClientSession() as session:
                with pytest.raises(WSServerHandshakeError) as refused:
                    await session.ws_connect(there.make_url("/ws"), origin="http://evil.example")
                assert refused.value.status == 403

        asyncio.run(go())


def test_without_the_extra_the_error_says_how_to_install_it(gaitsim, monkeypatch):
    monkeypatch.delitem(sys.modules, "gaitsim.tui.web")
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    stderr = gaitsim("serve", code=2).stderr
    assert "aiohttp" in stderr
    assert "pip install 'gaitsim[serve]'" in stderr


class TestListening:
    @pytest.mark.parametrize(
        ("host", "alone"),
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
    def test_what_is_this_machine_alone(self, host, alone):
        assert is_loopback(host) is alone

    def test_the_port_is_held(self, free):
        with listening("127.0.0.1", free) as held:
            assert held.getsockname() == ("127.0.0.1", free)

    def test_a_port_that_is_taken(self, gaitsim):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            said = gaitsim("serve", "--port", port, code=2).stderr
        assert f"cannot listen on 127.0.0.1, port {port}" in said
        assert "--port" in said

    @pytest.mark.parametrize(
        "bad",
        [
            ["--host", "nowhere.invalid"],
            ["--host", ""],
            ["--host", "300.1.1.1"],
            ["--host", "1" * 300],
            ["--port", "0"],
            ["--port", "70000"],
            ["--port", "x"],
            ["--theme", "gaitsim-lite"],
        ],
    )
    def test_what_cannot_be(self, gaitsim, bad):
        assert "Traceback" not in gaitsim("serve", *bad, code=2).stderr

    def test_a_warning_where_others_can_come(self, gaitsim, monkeypatch, free):
        monkeypatch.setattr(WebServer, "serve_on", lambda *_: None)
        assert "no login" in gaitsim("serve", "--host", "0.0.0.0", "--port", free).stderr
        assert gaitsim("serve", "--port", free).stderr == ""

    def test_the_app_gets_its_folder_and_theme(self, monkeypatch, gaitsim, free):
        commands = []
        monkeypatch.setattr(
            WebServer, "serve_on", lambda server, _: commands.append(server.command)
        )
        gaitsim("serve", "my runs", "--port", free, "--theme", "nord")
        assert commands[0].endswith("-m gaitsim tui 'my runs' --theme nord")


class TestTui:
    def test_without_a_terminal_it_says_so(self, program):
        said = program("tui", code=2).stderr
        assert "needs a terminal" in said

    def test_an_unknown_theme(self, gaitsim, monkeypatch):
        monkeypatch.setenv("TEXTUAL_DRIVER", "none")
        said = gaitsim("tui", "--theme", "gaitsim-lite", code=2).stderr
        assert "did you mean 'gaitsim-light'?" in said


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_a_run_is_begun_and_progresses_in_a_browser(start, tmp_path, free, puppet_file):
    playwright = pytest.importorskip("playwright.sync_api")
    flags = (
        "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
        "--disable-component-update --disable-sync"
    )
    text = puppet_file.read_text().replace("generations = 5", "generations = 100000")
    (tmp_path / "long.toml").write_text(text)
    server = start("serve", "--port", free, env=_environment(tmp_path))
    assert f"http://127.0.0.1:{free}" in server.stdout.readline()
    history = tmp_path / "runs" / "puppet" / "history.csv"
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags.split())
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        asked, drawn = [], []
        page.on("request", lambda request: asked.append(request.url))
        page.on(
            "websocket",
            lambda socket: socket.on("framereceived", lambda frame: drawn.append(_bytes(frame))),
        )
        page.goto(f"http://127.0.0.1:{free}/")
        page.wait_for_selector("body.-first-byte")

        def see(text):
            """Wait until the app has drawn a text."""
            page.wait_for_timeout(50)
            for _ in range(600):
                if text.encode() in b"".join(drawn):
                    return
                page.wait_for_timeout(100)
            raise AssertionError(f"{text} is not drawn")

        see("No runs in runs yet")
        page.keyboard.press("n")
        see("It can run")
        page.keyboard.press("Control+l")
        see("Begin with the file")
        page.keyboard.type("long.toml")
        page.keyboard.press("Enter")
        see("gaitsim run ./long.toml")
        drawn.clear()
        page.keyboard.press("Control+r")
        see("running")
        for _ in range(600):
            if history.exists() and history.read_text().count("\n") > 20:
                break
            page.wait_for_timeout(100)
        before = history.read_text().count("\n")
        drawn.clear()
        see("evaluations/s")
        assert before > 20
        assert all(url.startswith(f"http://127.0.0.1:{free}/") for url in asked)
        browser.close()
    server.terminate()
    server.wait(30)


def _bytes(frame):
    return frame if isinstance(frame, bytes) else frame.encode()


def _environment(folder):
    puppets = Path(__file__).parents[1] / "puppets"
    return os.environ | {"PYTHONPATH": str(puppets), "XDG_CONFIG_HOME": str(folder / "config")}
