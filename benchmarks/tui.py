"""The terminal UI: its cost for a run, its output to the terminal, and its response times.

The same run of a spider is executed in turns on the command line with `--json`, and on the live
screen in pseudo-terminals of several sizes, whose output is counted. Then the app opens many runs.
The benchmark measures the time from the start to the first screen and to the first run in the
list, and from a key to the end of the response.

To compare two versions of gaitsim, run this file in turns with the interpreters of both.
"""

import argparse
import contextlib
import fcntl
import os
import pty
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from timing import milliseconds, print_figure, print_machine

from gaitsim.experiment import load_experiment
from gaitsim.storage.creation import create_run

# The app of `gaitsim tui`, with one run that it resumes immediately. After the run it writes the
# start and the end of the measurement, the seconds per generation, the redraws of the panels per
# second, and the share of one core that its own process used.
APP = """
import sys, time
from pathlib import Path
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens.live import Live

class Benchmark(GaitsimApp):
    started, drawn = None, 0

    def on_mount(self):
        self.live = Live(Path(sys.argv[1]), resume=True)
        curves = self.live.board.curves
        self.show, curves.set_series = curves.set_series, self.count
        self.push_screen(self.live)
        self.set_interval(0.02, self.look)

    def count(self, *series, **labels):
        self.drawn += 1
        self.show(*series, **labels)

    def look(self):
        if not self.live.is_mounted:
            return
        now, snapshot, drawn = time.perf_counter(), self.live.snapshot, self.drawn
        if self.started is None and snapshot.generation >= int(sys.argv[3]):
            self.started = now, snapshot.generation, drawn, time.process_time()
        if snapshot.ended and snapshot.state != "stopped":
            then, first, before, used = self.started
            seconds, used = now - then, time.process_time() - used
            generation = seconds / (snapshot.generation - first)
            self.exit((then, now, generation, (drawn - before) / seconds, used / seconds))

app = Benchmark(Path(sys.argv[1]).parent)
Path(sys.argv[2]).write_text("{} {} {} {} {}".format(*app.run()))
"""
SIZES = ((80, 24), (120, 34), (160, 48))
QUIET = 0.2  # seconds without output that end a response
DOWN, PRESSES = b"\x1b[B", 9
DAY = 86400
SETTLED = 8.0  # seconds until the app has read all runs


class Terminal:
    """A command in a pseudo-terminal, with the time and size of each of its outputs."""

    def __init__(self, command: Sequence[str], columns: int, lines: int) -> None:
        self.keys, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        self.written: list[tuple[float, bytes]] = []
        self.started = time.perf_counter()
        # Textual writes to standard error.
        self.process = subprocess.Popen(
            command,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env=os.environ | {"TERM": "xterm-256color", "COLORTERM": "truecolor"},
            start_new_session=True,
        )
        os.close(theirs)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError):  # a closed pseudo-terminal raises OSError
            while data := os.read(self.keys, 65536):
                self.written.append((time.perf_counter(), data))

    def count(self, start: float, end: float) -> int:
        """Return the number of bytes written between two times."""
        return sum(len(data) for moment, data in self.written if start <= moment <= end)

    def wait_for(self, text: bytes) -> float:
        """Wait until a string is printed, and return the time."""
        while text not in b"".join(data for _, data in self.written):
            time.sleep(0.001)
            if self.process.poll() is not None:
                raise SystemExit("the UI exited")
        return self.written[-1][0]

    def wait_until_quiet(self, seconds: float = QUIET) -> float:
        """Wait until there is no output for `seconds`, and return the time of the last byte."""
        while time.perf_counter() - self.written[-1][0] < seconds:
            time.sleep(0.001)
        return self.written[-1][0]

    def press(self, key: bytes) -> float:
        """Press a key, and return the seconds until the end of the response."""
        before, then = len(self.written), time.perf_counter()
        os.write(self.keys, key)
        while len(self.written) == before and time.perf_counter() - then < 5:
            time.sleep(0.0005)
        return self.wait_until_quiet() - then

    def response_time(self, key: bytes) -> float:
        """Return the median response time of several presses, seconds."""
        return statistics.median(self.press(key) for _ in range(PRESSES))

    def close(self) -> None:
        """Terminate the command, and wait for its end."""
        self.process.kill()
        self.wait()

    def wait(self) -> int:
        """Wait for the end of the command."""
        code = self.process.wait()
        self._reader.join()
        os.close(self.keys)
        return code


def command_line_seconds(run: Path, warm: int) -> float:
    """Return the seconds per generation on the command line, after generation `warm`."""
    command = [sys.executable, "-m", "gaitsim", "resume", str(run), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        moments = [time.perf_counter() for _ in process.stdout]
    moments.pop()  # the summary
    return (moments[-1] - moments[warm - 1]) / (len(moments) - warm)


def ui_figures(run: Path, warm: int, columns: int, lines: int) -> list[float]:
    """Return seconds per generation, redraws/s, the UI's share of a core, and bytes/s."""
    figures = run.parent / "figures"
    command = [sys.executable, "-c", APP, str(run), str(figures), str(warm)]
    terminal = Terminal(command, columns, lines)
    if terminal.wait():
        raise SystemExit("the UI failed")
    then, now, *rest = map(float, figures.read_text().split())
    return [*rest, terminal.count(then, now) / (now - then)]


def response_times(folder: Path, run: Path, count: int) -> list[float]:
    """Return the response times of the app with many runs, seconds.

    Returns:
        Start to first screen, start to first run, a key on the home screen, a frame of the
        replay, and a generation of the replay.
    """
    runs = folder / "many"
    long_ago = time.time() - DAY
    for number in range(count):
        copy = runs / f"run-{number:03}"
        shutil.copytree(run, copy)
        for path in (*copy.rglob("*"), copy):
            os.utime(path, (long_ago, long_ago))
    terminal = Terminal([sys.executable, "-m", "gaitsim", "tui", str(runs)], 120, 34)
    drawn = terminal.wait_for(b"palette") - terminal.started
    listed = terminal.wait_for(b"run-") - terminal.started
    time.sleep(SETTLED)
    key = terminal.response_time(DOWN)
    os.write(terminal.keys, b"r")
    time.sleep(SETTLED)
    terminal.press(b" ")  # the replay starts playing immediately
    figures = [drawn, listed, key, terminal.response_time(b"."), terminal.response_time(b"[")]
    terminal.close()
    shutil.rmtree(runs)
    return figures


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--preset", default="spider-genetic")
    parser.add_argument("--generations", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print_machine()
    experiment = load_experiment(given.preset, {"evolution.generations": given.generations})
    warm = given.generations // 5
    plain: list[float] = []
    shown: dict[tuple[int, int], list[list[float]]] = {size: [] for size in SIZES}
    responses = []
    with tempfile.TemporaryDirectory(prefix=".benchmark-", dir=Path.cwd()) as name:
        folder = Path(name)
        for _ in range(given.rounds):
            run = create_run(experiment, folder / "command")
            plain.append(command_line_seconds(run, warm))
            for size in SIZES:
                shown[size].append(ui_figures(create_run(experiment, folder / "ui"), warm, *size))
            responses.append(response_times(folder, run, given.runs))
    alone = statistics.median(plain)
    print_figure(f"a generation of {given.preset}, command line, no display", milliseconds(alone))
    for (columns, lines), figures in shown.items():
        under, drawn, share, sent = map(statistics.median, zip(*figures, strict=True))
        beside = f"{under / alone - 1:+.0%} time"
        print_figure(f"the same in the UI, {columns} × {lines}", milliseconds(under), beside)
        print_figure("  sent to the terminal", f"{sent / 1000:.1f} kB/s")
        print_figure("  redraws of the panels per second", f"{drawn:.1f}")
        print_figure("  the UI's own process", f"{share:.0%}", "of one core")
    names = (
        f"from the start to the first screen, {given.runs} runs",
        "  to the first run in the list",
        f"from a key to the end of the response, {given.runs} runs",
        "  one frame of the replay",
        "  one generation of the replay",
    )
    for what, seconds in zip(
        names, map(statistics.median, zip(*responses, strict=True)), strict=True
    ):
        print_figure(what, milliseconds(seconds))


if __name__ == "__main__":
    main()
