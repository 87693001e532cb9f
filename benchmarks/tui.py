"""What the terminal UI costs a run and the terminal, and how soon it answers.

The same spider run, in turns: by the command line with `--json`, and on the live screen in
pseudo-terminals of several sizes, whose output is counted. Then the app on many runs: from its
start to the first picture and to the first run in it, and from a key to the end of its answer.

To compare two versions, run this file in turns with the interpreters of both.
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
from gaitsim.runs.files.folder import create_run

# The app as `gaitsim tui` has it, showing one run that goes on at once. At its end it says from
# when to when it was measured, how long a generation took, how often a second the panels were
# drawn, and what share of one core its own process took.
APP = """
import sys, time
from pathlib import Path
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens.live import Live

class Benchmark(GaitsimApp):
    begun, drawn = None, 0

    def on_mount(self):
        self.live = Live(Path(sys.argv[1]), go=True)
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
        if self.begun is None and snapshot.generation >= int(sys.argv[3]):
            self.begun = now, snapshot.generation, drawn, time.process_time()
        if snapshot.ended and snapshot.state != "stopped":
            then, first, before, used = self.begun
            seconds, used = now - then, time.process_time() - used
            generation = seconds / (snapshot.generation - first)
            self.exit((then, now, generation, (drawn - before) / seconds, used / seconds))

app = Benchmark(Path(sys.argv[1]).parent)
Path(sys.argv[2]).write_text("{} {} {} {} {}".format(*app.run()))
"""
SIZES = ((80, 24), (120, 34), (160, 48))
QUIET = 0.2  # seconds without output after which an answer has ended
DOWN, PRESSES = b"\x1b[B", 9
DAY = 86400
SETTLED = 8.0  # seconds after which the app has read what it shows


class Terminal:
    """A command in a pseudo-terminal, and when it wrote how much."""

    def __init__(self, command: Sequence[str], columns: int, lines: int) -> None:
        self.keys, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
        self.written: list[tuple[float, bytes]] = []
        self.begun = time.perf_counter()
        # Textual draws on standard error.
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
        with contextlib.suppress(OSError):  # a pseudo-terminal's way to say that it was closed
            while data := os.read(self.keys, 65536):
                self.written.append((time.perf_counter(), data))

    def count(self, start: float, end: float) -> int:
        """Bytes written between two moments."""
        return sum(len(data) for moment, data in self.written if start <= moment <= end)

    def until(self, text: bytes) -> float:
        """Wait for a text; return its moment."""
        while text not in b"".join(data for _, data in self.written):
            time.sleep(0.001)
            if self.process.poll() is not None:
                raise SystemExit("the UI ended")
        return self.written[-1][0]

    def until_quiet(self, seconds: float = QUIET) -> float:
        """Wait until nothing is written for a time; return the moment of the last byte."""
        while time.perf_counter() - self.written[-1][0] < seconds:
            time.sleep(0.001)
        return self.written[-1][0]

    def press(self, key: bytes) -> float:
        """Seconds from a key to the end of its answer."""
        before, then = len(self.written), time.perf_counter()
        os.write(self.keys, key)
        while len(self.written) == before and time.perf_counter() - then < 5:
            time.sleep(0.0005)
        return self.until_quiet() - then

    def answers(self, key: bytes) -> float:
        """The median of several presses."""
        return statistics.median(self.press(key) for _ in range(PRESSES))

    def close(self) -> None:
        """End the command, and wait for it."""
        self.process.kill()
        self.wait()

    def wait(self) -> int:
        """Wait for the end of the command."""
        code = self.process.wait()
        self._reader.join()
        os.close(self.keys)
        return code


def by_command(run: Path, warm: int) -> float:
    """Seconds a generation by the command line, from generation `warm` on."""
    command = [sys.executable, "-m", "gaitsim", "resume", str(run), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        moments = [time.perf_counter() for _ in process.stdout]
    moments.pop()  # the summary
    return (moments[-1] - moments[warm - 1]) / (len(moments) - warm)


def under_ui(run: Path, warm: int, columns: int, lines: int) -> list[float]:
    """Under the UI: seconds a generation, panels drawn a second, its share of a core, bytes/s."""
    figures = run.parent / "figures"
    command = [sys.executable, "-c", APP, str(run), str(figures), str(warm)]
    terminal = Terminal(command, columns, lines)
    if terminal.wait():
        raise SystemExit("the UI failed")
    then, now, *rest = map(float, figures.read_text().split())
    return [*rest, terminal.count(then, now) / (now - then)]


def on_many(folder: Path, run: Path, count: int) -> list[float]:
    """Of the app on many runs: first paint, first run, a key at home, a frame, a generation."""
    runs = folder / "many"
    long_ago = time.time() - DAY
    for number in range(count):
        copy = runs / f"run-{number:03}"
        shutil.copytree(run, copy)
        for path in (*copy.rglob("*"), copy):
            os.utime(path, (long_ago, long_ago))
    terminal = Terminal([sys.executable, "-m", "gaitsim", "tui", str(runs)], 120, 34)
    painted = terminal.until(b"palette") - terminal.begun
    listed = terminal.until(b"run-") - terminal.begun
    time.sleep(SETTLED)
    key = terminal.answers(DOWN)
    os.write(terminal.keys, b"r")
    time.sleep(SETTLED)
    terminal.press(b" ")  # it plays at once
    figures = [painted, listed, key, terminal.answers(b"."), terminal.answers(b"[")]
    terminal.close()
    shutil.rmtree(runs)
    return figures


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--preset", default="spider")
    parser.add_argument("--generations", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print_machine()
    experiment = load_experiment(given.preset, {"evolution.generations": given.generations})
    warm = given.generations // 5
    plain: list[float] = []
    shown: dict[tuple[int, int], list[list[float]]] = {size: [] for size in SIZES}
    answers = []
    with tempfile.TemporaryDirectory(prefix=".benchmark-", dir=Path.cwd()) as name:
        folder = Path(name)
        for _ in range(given.rounds):
            run = create_run(experiment, folder / "command")
            plain.append(by_command(run, warm))
            for size in SIZES:
                shown[size].append(under_ui(create_run(experiment, folder / "ui"), warm, *size))
            answers.append(on_many(folder, run, given.runs))
    alone = statistics.median(plain)
    print_figure(f"a generation of {given.preset}, command line, no display", milliseconds(alone))
    for (columns, lines), figures in shown.items():
        under, drawn, share, sent = map(statistics.median, zip(*figures, strict=True))
        beside = f"{under / alone - 1:+.0%} time"
        print_figure(f"the same under the UI, {columns} × {lines}", milliseconds(under), beside)
        print_figure("  sent to the terminal", f"{sent / 1000:.1f} kB/s")
        print_figure("  panels drawn a second", f"{drawn:.1f}")
        print_figure("  the UI's own process", f"{share:.0%}", "of one core")
    names = (
        f"from the start to the first picture, {given.runs} runs",
        "  to the first run in the list",
        f"from a key to the end of its answer, {given.runs} runs",
        "  one frame of the replay",
        "  one generation of the replay",
    )
    for what, seconds in zip(
        names, map(statistics.median, zip(*answers, strict=True)), strict=True
    ):
        print_figure(what, milliseconds(seconds))


if __name__ == "__main__":
    main()
