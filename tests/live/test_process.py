"""Runs that evolve in their own process."""

import asyncio
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from gaitsim.live.process import RunProcess, background_state, start_detached, stop
from gaitsim.storage.background import last_failure
from gaitsim.storage.lock import is_locked
from gaitsim.storage.snapshot import RunSnapshot

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
SLOW = ("organism.pause=0.01",)


@pytest.fixture
def uninterrupted(new_run, gaitsim):
    """A function that evolves a run without interruption, and returns its fingerprint."""

    def uninterrupted(*overrides, **options):
        path = new_run("uninterrupted", *overrides, **options)
        gaitsim("resume", path)
        return RunSnapshot(path).fingerprint()

    return uninterrupted


async def final_snapshot(process):
    """Wait for the end of a process; return its last snapshot."""
    async for snapshot in process:
        if snapshot.ended:
            break
    return await process.wait_ended()


async def test_a_process_pauses_continues_and_changes_options(new_run, wait):
    path = new_run("run", *SLOW, generations=10_000)
    process = RunProcess(path, paused=True)
    await process.start()
    await wait(lambda: process.last.state == "paused")
    assert process.last.generation == 0
    process.step()
    await wait(lambda: process.last.generation == 1 and process.last.state == "paused")
    assert is_locked(path)
    process.change({"fitness.price": 0.7})
    await wait(lambda: process.last.stage == 2 and process.last.state == "paused")
    process.go()
    await wait(lambda: process.last.generation > 5)
    process.pause()
    await wait(lambda: process.last.state == "paused")
    process.stop()
    snapshot = await final_snapshot(process)
    assert snapshot.state == "stopped"
    assert snapshot.generations == 10_000
    assert RunSnapshot(path).generation == snapshot.generation > 5


PARENT = """
import asyncio, sys
from pathlib import Path
from gaitsim.live.process import RunProcess
async def main():
    async for snapshot in RunProcess(Path("run")):
        print(snapshot.generation, flush=True)
asyncio.run(main())
"""


@pytest.mark.slow
def test_a_run_continues_after_its_parent_is_killed(new_run, uninterrupted):
    path = new_run("run", *SLOW, generations=100_000)
    for goal in (1, 30):
        parent = subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE)
        while int(parent.stdout.readline()) < goal:
            pass
        parent.kill()
        parent.wait()
        parent.stdout.close()
        assert background_state(path) == "running"
    assert stop(path)
    done = RunSnapshot(path)
    assert done.fingerprint() == uninterrupted(*SLOW, generations=done.generation)


def test_ctrl_c_in_the_terminal_does_not_reach_the_process(new_run, wait):
    path = new_run("run", *SLOW)

    async def interrupt():
        process = RunProcess(path)
        await process.start()
        await wait(lambda: process.last.generation > 2)
        os.kill(process.pid, signal.SIGINT)
        assert os.getsid(process.pid) != os.getsid(0)
        return await final_snapshot(process)

    assert asyncio.run(interrupt()).state == "finished"


async def test_a_killed_process_is_reported(new_run, wait):
    path = new_run("run", *SLOW, generations=10_000)
    process = RunProcess(path)
    await process.start()
    await wait(lambda: process.last.generation > 2)
    process.kill()
    snapshot = await final_snapshot(process)
    process.go()
    process.stop()
    assert (snapshot.state, snapshot.evaluations_per_second) == ("failed", 0)
    assert "was killed or crashed" in snapshot.error.what
    assert str(last_failure(path)) == str(snapshot.error)
    assert "gaitsim resume run" in snapshot.error.remedy


def test_invalid_options_are_reported_at_once(new_run):
    process = RunProcess(new_run(), overrides={"mutation.rat": 2, "search.elites": -1})
    snapshot = asyncio.run(final_snapshot(process))
    assert snapshot.state == "failed"
    assert "rat" in str(snapshot.error)
    assert "elites" in str(snapshot.error)


NOISY = """
import sys
from gaitsim_puppets import Puppet
class Noisy(Puppet):
    def move(self, genomes):
        print('{"state": "finished"}', flush=True)
        print("so much", file=sys.stderr, flush=True)
        assert sys.stdin.read() == ""
        return super().move(genomes)
"""


def test_a_plugin_that_prints_and_reads_does_not_disturb_messages(new_run, install, monkeypatch):
    folder = install("noisy", NOISY, {"organism": {"noisy": "Noisy"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    start_detached(path := new_run("run", "organism.plugin=noisy"), workers=2)
    snapshot = asyncio.run(final_snapshot(RunProcess(path)))
    assert (snapshot.state, snapshot.generation) == ("finished", 30), snapshot.error


DEADLY = """
import ctypes, sys
from gaitsim_puppets import Puppet
class Deadly(Puppet):
    def move(self, genomes):
        if len(genomes) > 1:
            print("[bold]I end it all", file=sys.stderr, flush=True)
            ctypes.CDLL(None)._exit(3)
        return super().move(genomes)
"""


def test_a_plugin_that_exits_is_reported_with_its_last_line(new_run, install, monkeypatch):
    folder = install("deadly", DEADLY, {"organism": {"deadly": "Deadly"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    snapshot = asyncio.run(final_snapshot(RunProcess(new_run("run", "organism.plugin=deadly"))))
    assert snapshot.state == "failed"
    assert "its log ends with: [bold]I end it all" in snapshot.error.what


def test_no_user_interface_is_imported(new_run):
    code = (
        "import os, sys; sys.argv = ['x', 'run']; os.fork = lambda: 0\n"
        "from gaitsim.live.__main__ import main\n"
        "main(); print({'typer', 'rich', 'textual', 'matplotlib'} & {*sys.modules}, "
        "file=open('imported', 'w'))"
    )
    new_run()
    subprocess.run([sys.executable, "-c", code], check=True)
    assert Path("imported").read_text() == "set()\n"
