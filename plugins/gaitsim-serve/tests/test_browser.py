"""The UI in Chromium: it works with its token, and pages of other sites cannot reach it."""

import os
import re
import signal
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread

import pytest
from javascript import CHROMIUM
from waiting import until

FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
)
# A move to a place, a move to the right, or a text; other sequences change no cell.
DRAWN = re.compile(r"\x1b\[(?:(\d+;\d+)H|(\d+)C|[?\d;]*\$?[a-zA-Z])|([^\x00-\x1f]+)")
PUPPETS = Path(__file__).parents[3] / "tests" / "puppets"

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")


@pytest.fixture
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    with playwright.sync_playwright() as driver:
        yield driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS.split())


@pytest.fixture
def serve(start, tmp_path):
    """A function that starts a server, and returns its process and address."""

    def serve(*options):
        config = {"PYTHONPATH": str(PUPPETS), "XDG_CONFIG_HOME": str(tmp_path / "config")}
        server = start("serve", "--port", _free(), *options, env=os.environ | config)
        return server, server.stdout.readline().split()[-1]

    return serve


class Window:
    """A page that shows the app, and the rows that the app has drawn on it."""

    def __init__(self, context, address):
        self.page = context.new_page()
        self.requested, self.rows, self.at = [], {}, (1, 1)
        self.page.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: socket.on("framereceived", self._draw))
        self.page.goto(address)
        self.page.wait_for_selector("body.-first-byte")

    def _draw(self, frame):
        """Follow moves and texts, because only changed cells are sent."""
        drawn = frame.decode() if isinstance(frame, bytes) else ""
        for move, right, text in DRAWN.findall(drawn):
            row, column = self.at
            if move:
                row, column = map(int, move.split(";"))
            column += int(right or 0)
            shown = self.rows.get(row, "").ljust(column - 1)
            self.rows[row] = shown[: column - 1] + text + shown[column - 1 + len(text) :]
            self.at = row, column + len(text)

    def see(self, text):
        """Wait until the app shows a text."""
        self.until(lambda: any(text in row for row in self.rows.values()))

    def until(self, holds):
        """Wait until a condition holds, while the browser runs."""

        def now():
            self.page.wait_for_timeout(50)
            return holds()

        until(now)

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)


@pytest.mark.slow
def test_a_run_started_in_a_browser_outlives_its_window(
    serve, browser, program, tmp_path, puppet_file
):
    text = puppet_file.read_text().replace("generations = 5", "generations = 100000")
    (tmp_path / "long.toml").write_text(text)
    server, address = serve("--theme", "gaitsim-light")
    history = tmp_path / "runs" / "puppet" / "history.csv"
    window = Window(browser, address)
    window.see("There are no runs in runs/ yet")
    for place in ("document.body", "document.querySelector('.xterm-viewport')"):
        ground = f"getComputedStyle({place}).backgroundColor"
        window.until(lambda: window.page.evaluate(ground) == "rgb(247, 248, 246)")  # noqa: B023
    window.press("n")
    window.see("choose a preset")
    window.press("Control+l")
    window.see("A robot (URDF, MJCF) or an experiment (TOML)")
    window.page.keyboard.type("long.toml")
    window.see("long.toml  experiment")
    window.press("Enter")
    window.see("gaitsim run ./long.toml")
    window.press("Control+r")
    window.see("running")
    window.until(lambda: history.exists() and history.read_text().count("\n") > 20)
    window.see("evaluations/s")
    page, _, query = address.partition("?")
    assert window.page.url == page
    assert query not in "".join(window.requested[1:])
    assert all(url.startswith(page) for url in window.requested)
    browser.close()
    server.send_signal(signal.SIGINT)
    assert server.wait(60) == 0
    before = history.read_text().count("\n")
    until(lambda: history.read_text().count("\n") > before + 20)
    program("stop", "puppet")


@pytest.mark.slow
def test_a_page_opens_in_another_tab_isolated_from_the_app(serve, browser, walk):
    walk()
    _, address = serve()
    context = browser.new_context()
    window = Window(context, address)
    window.see("walk")
    window.press("r")
    window.see("★")  # before the individual has been read, the screen has no key B
    seen, requested = [], []
    with context.expect_page() as opened:
        window.press("B")
    tab = opened.value
    tab.on("console", lambda message: seen.append(message.text))
    tab.on("request", lambda request: requested.append(request.url))
    tab.wait_for_selector("canvas")
    page = address.partition("?")[0]
    assert tab.url.startswith(f"{page}pages/")
    assert tab.evaluate("[globalThis.origin, window.opener]") == ["null", None]
    tab.reload()
    tab.wait_for_selector("canvas")
    assert {url for url in requested if not url.startswith("about:")} == {tab.url}
    assert [text for text in seen if "GL Driver Message" not in text] == []  # without a GPU


@pytest.mark.slow
class TestAttacks:
    def test_a_frame_in_another_page_receives_no_keys(self, serve, browser, walk):
        """Otherwise, a page with the app in a frame could delete a run by keys typed on it."""
        run = walk()
        _, address = serve()
        context = browser.new_context()
        window = Window(context, address)
        window.see("walk")
        page = address.partition("?")[0]
        with _page(f"<iframe src='{page}' width='900' height='600'></iframe>") as foreign:
            framing = context.new_page()
            sockets = []
            framing.on("websocket", lambda socket: sockets.append(socket.url))
            framing.goto(foreign)
            framing.locator("iframe").click()
            assert framing.frames[1].url != page
            framing.keyboard.type("dy")
            assert not sockets
        assert run.is_dir()
        window.page.bring_to_front()
        window.press("d")
        window.see("Delete the run walk?")
        window.press("y")
        window.until(lambda: not run.exists())


@contextmanager
def _page(html):
    """Serve a page at another port; yield its address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(html.encode())

        def log_message(self, *_):
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}/"
        finally:
            server.shutdown()
            thread.join()


def _free():
    with HTTPServer(("127.0.0.1", 0), BaseHTTPRequestHandler) as server:
        return server.server_port
