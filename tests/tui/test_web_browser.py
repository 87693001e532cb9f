"""The UI in Chromium: it works with its token, and no other page's frame reaches it."""

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
PUPPETS = Path(__file__).parents[1] / "puppets"

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")


@pytest.fixture
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    with playwright.sync_playwright() as driver:
        yield driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS.split())


@pytest.fixture
def serve(start, tmp_path):
    """Starts a server; returns its process and address."""

    def serve(*options):
        config = {"PYTHONPATH": str(PUPPETS), "XDG_CONFIG_HOME": str(tmp_path / "config")}
        server = start("serve", "--port", _free(), *options, env=os.environ | config)
        return server, server.stdout.readline().split()[-1]

    return serve


class Window:
    """A page that shows the app, and the rows that the app has drawn on it."""

    def __init__(self, context, address):
        self.page = context.new_page()
        self.asked, self.rows, self.at = [], {}, (1, 1)
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("websocket", lambda socket: socket.on("framereceived", self._draw))
        self.page.goto(address)
        self.page.wait_for_selector("body.-first-byte")

    def _draw(self, frame):
        """Follow moves and texts; only cells that differ are sent."""
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
        """Wait until something holds, while the browser goes on."""

        def now():
            self.page.wait_for_timeout(50)
            return holds()

        until(now)

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)


@pytest.mark.slow
def test_a_run_is_begun_in_a_browser_and_outlives_its_window(
    serve, browser, program, tmp_path, puppet_file
):
    text = puppet_file.read_text().replace("generations = 5", "generations = 100000")
    (tmp_path / "long.toml").write_text(text)
    server, address = serve("--theme", "gaitsim-light")
    history = tmp_path / "runs" / "puppet" / "history.csv"
    window = Window(browser, address)
    window.see("No runs in runs yet")
    for place in ("document.body", "document.querySelector('.xterm-viewport')"):
        ground = f"getComputedStyle({place}).backgroundColor"
        window.until(lambda: window.page.evaluate(ground) == "rgb(247, 248, 246)")  # noqa: B023
    window.press("n")
    window.see("Ready to run")
    window.press("Control+l")
    window.see("Load the file")
    window.page.keyboard.type("long.toml")
    window.press("Enter")
    window.see("gaitsim run ./long.toml")
    window.press("Control+r")
    window.see("running")
    window.until(lambda: history.exists() and history.read_text().count("\n") > 20)
    window.see("evaluations/s")
    page, _, query = address.partition("?")
    assert window.page.url == page
    assert query not in "".join(window.asked[1:])
    assert all(url.startswith(page) for url in window.asked)
    browser.close()
    server.send_signal(signal.SIGINT)
    assert server.wait(60) == 0
    before = history.read_text().count("\n")
    until(lambda: history.read_text().count("\n") > before + 20)
    program("stop", "puppet")


@pytest.mark.slow
def test_a_page_opens_in_another_tab_apart_from_the_app(serve, browser, walk):
    walk()
    _, address = serve()
    context = browser.new_context()
    window = Window(context, address)
    window.see("walk")
    window.press("r")
    window.see("replay")
    seen, asked = [], []
    with context.expect_page() as opened:
        window.press("B")
    tab = opened.value
    tab.on("console", lambda message: seen.append(message.text))
    tab.on("request", lambda request: asked.append(request.url))
    tab.wait_for_selector("canvas")
    page = address.partition("?")[0]
    assert tab.url.startswith(f"{page}pages/")
    assert tab.evaluate("[globalThis.origin, window.opener]") == ["null", None]
    tab.reload()
    tab.wait_for_selector("canvas")
    assert {url for url in asked if not url.startswith("about:")} == {tab.url}
    assert [said for said in seen if "GL Driver Message" not in said] == []  # without a GPU


@pytest.mark.slow
class TestAttacks:
    def test_a_frame_of_another_page_gets_no_key(self, serve, browser, walk):
        """A page that had the app in a frame could delete a run by the keys typed on it."""
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

    def test_a_page_elsewhere_opens_no_connection(self, serve, browser):
        _, address = serve()
        context = browser.new_context()
        Window(context, address)
        socket = address.partition("?")[0].replace("http", "ws") + "ws"
        script = f"""<script>
            const socket = new WebSocket("{socket}");
            socket.onopen = () => document.title = "open";
            socket.onclose = () => document.title ||= "refused";
        </script>"""
        with _page(script) as foreign:
            page = context.new_page()
            page.goto(foreign)
            page.wait_for_function("document.title")
            assert page.title() == "refused"

    def test_without_the_token_there_is_a_field_for_it(self, serve, browser):
        _, address = serve()
        page, _, token = address.partition("?token=")
        shown = browser.new_context().new_page()
        assert shown.goto(page).status == 403
        shown.fill("input", token)
        shown.press("input", "Enter")
        shown.wait_for_selector("body.-first-byte")
        assert shown.url == page

    def test_a_window_too_many_says_so(self, serve, browser):
        _, address = serve("--windows", "1")
        context = browser.new_context()
        window = Window(context, address)
        second = context.new_page()
        second.goto(address)
        second.wait_for_selector("body.-closed")
        assert "--windows" in second.inner_text("#ended")
        window.press("q")
        window.page.wait_for_selector("body.-closed")
        second.click("#again")
        second.wait_for_selector("body.-first-byte")

    def test_apps_end_with_a_server_that_is_killed(self, serve, browser):
        server, address = serve()
        Window(browser, address)
        children = Path(f"/proc/{server.pid}/task/{server.pid}/children")
        if not children.exists():
            pytest.skip("processes are looked up in /proc")
        apps = [Path("/proc", process) for process in children.read_text().split()]
        server.kill()
        assert apps
        until(lambda: not any(_runs(app) for app in apps))


def _runs(process):
    """Whether a process runs, rather than being a zombie that nobody waits for."""
    try:
        return (process / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@contextmanager
def _page(html):
    """The address of a page at another port."""

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
