"""What the terminal UI costs a run that goes at full speed, and how often its screen is drawn.

The same spider run, in turns: by the command line with `--json`, and on the live screen in a
pseudo-terminal of 160 × 48 whose output is read and thrown away.
"""

import argparse
import contextlib
import fcntl
import os
import pty
import statistics
import struct
import subprocess
import sys
import tempfile
import termios
import time
from pathlib import Path

from timing import milliseconds, print_figure, print_machine

from gaitsim.experiment import load_experiment
from gaitsim.runs.files.folder import create_run

# The app as `gaitsim tui` has it, showing one run that goes on at once. At its end it says how
# long a generation took after the warm-up, how often a second the panels were drawn, and what
# share of one core its own process took.
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

    def count(self, *series):
        self.drawn += 1
        self.show(*series)

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
            self.exit((generation, (drawn - before) / seconds, used / seconds))

app = Benchmark(Path(sys.argv[1]).parent)
Path(sys.argv[2]).write_text("{} {} {}".format(*app.run()))
"""
COLUMNS, LINES = 160, 48


def by_command(run: Path, warm: int) -> float:
    """Seconds a generation by the command line, from generation `warm` on."""
    command = [sys.executable, "-m", "gaitsim", "resume", str(run), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        moments = [time.perf_counter() for _ in process.stdout]
    moments.pop()  # the summary
    return (moments[-1] - moments[warm - 1]) / (len(moments) - warm)


def under_ui(run: Path, warm: int) -> list[float]:
    """Under the UI: seconds a generation, panels drawn a second, its share of one core."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", LINES, COLUMNS, 0, 0))
    figures = run.parent / "figures"
    process = subprocess.Popen(
        [sys.executable, "-c", APP, str(run), str(figures), str(warm)],
        stdin=theirs,
        stdout=theirs,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"TERM": "xterm-256color", "COLORTERM": "truecolor"},
        start_new_session=True,
    )
    os.close(theirs)
    with contextlib.suppress(OSError):  # a pseudo-terminal's way to say that it was closed
        while os.read(ours, 65536):
            pass
    os.close(ours)
    if process.wait():
        raise SystemExit("the UI failed")
    return [*map(float, figures.read_text().split())]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--preset", default="spider")
    parser.add_argument("--generations", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print_machine()
    experiment = load_experiment(given.preset, {"evolution.generations": given.generations})
    warm = given.generations // 5
    plain, shown = [], []
    with tempfile.TemporaryDirectory(prefix=".benchmark-", dir=Path.cwd()) as folder:
        for _ in range(given.rounds):
            plain.append(by_command(create_run(experiment, Path(folder) / "command"), warm))
            shown.append(under_ui(create_run(experiment, Path(folder) / "ui"), warm))
    alone = statistics.median(plain)
    under, drawn, share = map(statistics.median, zip(*shown, strict=True))
    print_figure(f"a generation of {given.preset}, command line, no display", milliseconds(alone))
    print_figure(
        "the same under the UI, 160 × 48", milliseconds(under), f"{under / alone - 1:+.0%} time"
    )
    print_figure("panels drawn a second", f"{drawn:.1f}")
    print_figure("the UI's own process", f"{share:.0%}", "of one core")


if __name__ == "__main__":
    main()
