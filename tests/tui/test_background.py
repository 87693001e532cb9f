"""Runs started by the app outlive it, and are identical to runs of the command line."""

import os
import pty
import subprocess
import sys
import threading

import numpy as np
import pytest
from waiting import until

from gaitsim.live.process import background_state, start_detached, stop
from gaitsim.runs.snapshot import RunSnapshot

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="needs POSIX terminals"),
    pytest.mark.slow,  # in the default suite, test_live.py leaves and reopens a run
]


class Terminal:
    """`gaitsim tui` in a new terminal, with all output."""

    def __init__(self, *arguments):
        self._ours, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "gaitsim", "tui", *arguments],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env=os.environ | {"TERM": "xterm-256color", "COLUMNS": "80", "LINES": "24"},
            start_new_session=True,
        )
        os.close(theirs)
        self.written = b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        try:
            while data := os.read(self._ours, 65536):
                self.written += data
        except OSError:  # the other end is closed
            pass

    def press(self, key, shown=b""):
        """Press a key and wait until the app has written `shown`."""
        before = len(self.written)
        os.write(self._ours, key)
        until(lambda: shown in self.written[before:])

    def kill(self):
        self.process.kill()
        self.process.wait()
        self._reader.join()
        os.close(self._ours)


def test_runs_continue_after_the_app_is_killed_and_reopened(walk, gaitsim, monkeypatch):
    monkeypatch.setenv("GAITSIM_BACKGROUND_RUNS", "3")
    slow = "organism.pause=0.01"
    first = walk("walk", 0, slow, generations=100_000)
    more = [walk(f"../more/{name}", 0, slow, generations=100_000) for name in ("trot", "run")]
    app = Terminal("runs")
    until(lambda: b"walk" in app.written)
    app.press(b"\r", b"stopped")
    app.press(b" ")
    until(lambda: background_state(first) == "running")
    for run in more:
        start_detached(run)
    runs = [first, *more]
    until(lambda: all(RunSnapshot(run).generation > 1 for run in runs))
    app.kill()
    then = [RunSnapshot(run).generation for run in runs]
    again = Terminal("runs")
    until(lambda: b"walk" in again.written)
    again.press(b"\r", b"evaluations/s")
    again.press(b" ", b"n: evolve one")
    assert background_state(first) == "paused"
    again.press(b" ")
    until(lambda: background_state(first) == "running")
    again.kill()
    until(
        lambda: all(
            RunSnapshot(run).generation > before + 10
            for run, before in zip(runs, then, strict=True)
        )
    )
    for run in runs:
        assert stop(run)
        done = RunSnapshot(run)
        plain = walk(f"../plain/{run.name}", 0, slow, generations=done.generation)
        gaitsim("resume", plain)
        whole = RunSnapshot(plain)
        assert done.fingerprint() == whole.fingerprint()
        assert done.bests.tobytes() == whole.bests.tobytes()
        np.testing.assert_array_equal(done.checkpoint.genomes, whole.checkpoint.genomes)
        assert (done.history["best"] == whole.history["best"]).all()
