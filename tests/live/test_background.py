"""Processes that evolve runs in the background: their sockets, their queue and their ends."""

import errno
import json
import os
import random
import signal
import socket
import stat
import subprocess
import sys
import threading
from contextlib import closing, suppress
from pathlib import Path

import psutil
import pytest
from filelock import FileLock
from waiting import until

from gaitsim.errors import GaitsimError, RunError
from gaitsim.live.evolving import CommandQueue
from gaitsim.live.process import background_state, kill, send, start_detached, stop
from gaitsim.live.protocol import RunCommand, Snapshot, read_snapshot
from gaitsim.live.server import Hub, Presence
from gaitsim.live.slots import Slot, slot_count
from gaitsim.storage.background import (
    LOCK,
    SOCKET,
    STATUS,
    address,
    background_process,
    background_processes,
    create_runtime_folder,
    last_failure,
    runtime_file,
)
from gaitsim.storage.growing import overview
from gaitsim.storage.snapshot import RunSnapshot

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs Unix sockets")
SLOW = ("organism.pause=0.01",)


def fingerprint(path):
    return RunSnapshot(path).fingerprint()


def plain_fingerprint(new_run, generations, *overrides):
    """Return the fingerprint of a run that this process evolves to a generation."""
    from gaitsim.live.evolving import evolve_live
    from gaitsim.live.reporter import Reporter

    path = new_run("plain", *overrides, generations=generations)
    evolve_live(path, CommandQueue(), Reporter(lambda line: None))
    return fingerprint(path)


@pytest.fixture
def connect():
    """A function that connects to a run's process, and returns a file of its lines."""
    opened = []

    def connect(path):
        client = socket.socket(socket.AF_UNIX)
        opened.append(client)
        with address(runtime_file(path, SOCKET)) as name:
            client.connect(name)
        file = client.makefile("rwb")
        opened.append(file)
        return file

    yield connect
    for one in opened:
        one.close()


@pytest.mark.slow
def test_two_clients_receive_the_same_and_both_send_commands(new_run, connect):
    path = new_run("run", *SLOW, generations=100_000)
    start_detached(path, paused=True)
    until(lambda: background_state(path) == "paused")
    first, second = connect(path), connect(path)
    greetings = [json.loads(client.readline()) for client in (first, second)]
    assert [greeting["state"] for greeting in greetings] == ["paused", "paused"]
    assert greetings[0]["generations"] == 100_000
    first.write(b'nonsense\n[[[[\n{"do": "fly"}\n{"do":"step"}\n')
    first.flush()
    seen = [Snapshot("preparing"), Snapshot("preparing")]
    for index, client in enumerate((first, second)):
        while seen[index].generation < 1 or seen[index].state != "paused":
            seen[index] = read_snapshot(client.readline(), seen[index])
    assert seen[0].top[0].score == seen[1].top[0].score
    first.close()
    send(path, RunCommand("step"))
    while seen[1].generation < 2:
        seen[1] = read_snapshot(second.readline(), seen[1])
    late = read_snapshot(connect(path).readline(), Snapshot("preparing"))
    assert (late.generation, late.champion) == (2, seen[1].champion)
    assert late.top
    assert not late.rows
    assert stop(path)
    assert json.loads(second.readlines()[-1])["state"] == "stopped"
    assert fingerprint(path) == plain_fingerprint(new_run, 2, *SLOW)


@pytest.mark.slow
def test_a_killed_process_loses_at_most_a_generation_and_its_socket_is_replaced(new_run):
    path, drawn = new_run("run", *SLOW, generations=100_000), random.Random(2)
    for _ in range(3):
        start = RunSnapshot(path).generation
        start_detached(path)
        goal = start + drawn.randrange(1, 9)
        until(lambda goal=goal: RunSnapshot(path).generation >= goal)
        seen = RunSnapshot(path).generation
        kill(path)
        until(lambda: background_state(path) is None)
        assert runtime_file(path, SOCKET).exists()
        assert RunSnapshot(path).generation >= seen
        assert "killed or crashed" in str(last_failure(path))
        assert overview(path).state == "failed"
    start_detached(path)
    until(lambda: background_state(path) == "running")
    assert last_failure(path) is None
    stop(path)
    assert not any(runtime_file(path, kind).exists() for kind in (SOCKET, STATUS))
    done = RunSnapshot(path)
    assert done.fingerprint() == plain_fingerprint(new_run, done.generation, *SLOW)


@pytest.mark.slow
def test_only_one_of_several_started_processes_evolves_a_run(new_run):
    path = new_run("run", *SLOW, generations=100_000)
    link = Path("link")
    link.symlink_to(path)
    answers = []

    def start(name):
        try:
            answers.append(start_detached(name))
        except GaitsimError as error:
            answers.append(str(error))

    threads = [threading.Thread(target=start, args=[name]) for name in (path, link, path)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (pid,) = [answer for answer in answers if isinstance(answer, int)]
    assert background_process(link).pid == pid
    assert all("background" in answer for answer in answers if answer != pid)


@pytest.mark.slow
def test_runs_start_in_order_and_a_paused_run_frees_its_slot(new_run, monkeypatch):
    monkeypatch.setenv("GAITSIM_BACKGROUND_RUNS", "1")
    first, second, third = [new_run(name, *SLOW, generations=100_000) for name in "abc"]
    for path in (first, second, third):
        start_detached(path)
    until(lambda: background_state(first) == "running")
    until(lambda: [background_state(second), background_state(third)] == ["queued", "queued"])
    send(first, RunCommand("pause"))
    until(lambda: background_state(second) == "running")
    assert (background_state(first), background_state(third)) == ("paused", "queued")
    send(first, RunCommand("go"))
    until(lambda: background_state(first) == "queued")
    kill(second)
    until(lambda: background_state(third) == "running")
    assert background_state(first) == "queued"
    stop(third)
    until(lambda: background_state(first) == "running")


class TestSlots:
    def test_tickets_are_served_in_order(self, tmp_path):
        waiting = [Slot(tmp_path, 2, tmp_path / name) for name in "abcd"]
        assert [slot.try_acquire() for slot in waiting] == [True, True, False, False]
        waiting[1].release()
        assert [slot.try_acquire() for slot in waiting] == [True, False, True, False]
        waiting[0].release()
        assert [waiting[index].try_acquire() for index in (3, 1)] == [True, False]

    def test_tickets_of_dead_processes_do_not_count(self, tmp_path):
        (tmp_path / "queue").mkdir()
        (tmp_path / "queue" / "000000000007").touch()
        first, second = Slot(tmp_path, 1, tmp_path / "a"), Slot(tmp_path, 1, tmp_path / "b")
        assert first.try_acquire()
        assert not second.try_acquire()
        assert sorted(path.name[:12] for path in (tmp_path / "queue").iterdir()) == [
            "000000000008",
            "000000000009",
        ]

    def test_a_broken_folder_lets_every_run_evolve(self, tmp_path):
        (tmp_path / "queue").touch()
        assert Slot(tmp_path, 1, tmp_path / "a").try_acquire()
        assert Slot(tmp_path, 1, tmp_path / "b").try_acquire()

    @pytest.mark.parametrize("given", ["0", "two", "²"])
    def test_an_invalid_number_is_rejected(self, monkeypatch, given):
        monkeypatch.setenv("GAITSIM_BACKGROUND_RUNS", given)
        with pytest.raises(GaitsimError, match="GAITSIM_BACKGROUND_RUNS"):
            slot_count()


class TestHub:
    @pytest.fixture
    def hub(self, tmp_path):
        listener = socket.socket(socket.AF_UNIX)
        with address(tmp_path / "hub") as name:
            listener.bind(name)
        listener.listen()
        commands = CommandQueue()
        hub = Hub(listener, commands.add)
        hub.serve(lambda: b"hello\n")
        hub.commands, hub.path = commands, tmp_path / "hub"
        yield hub
        hub.close()

    def client(self, hub):
        client = socket.socket(socket.AF_UNIX)
        client.settimeout(60)
        with address(hub.path) as name:
            client.connect(name)
        assert client.recv(6) == b"hello\n"
        return client

    def test_a_slow_client_is_disconnected_and_others_are_served(self, hub, monkeypatch):
        monkeypatch.setattr("gaitsim.live.server.PATIENCE", 0.2)
        with closing(self.client(hub)) as slow, closing(self.client(hub)) as quick:
            quick_file = quick.makefile("rb")
            line = b"x" * 2**20 + b"\n"

            def served():
                hub.write(line)
                assert quick_file.readline() == line
                return len(hub._clients) == 1

            until(served)
            quick_file.close()
            assert received_by(slow) < 2**22

    def test_an_endless_line_ends_its_connection(self, hub):
        with closing(self.client(hub)) as client, pytest.raises(OSError, match=r"reset|Broken"):
            client.sendall(b"x" * 2**27)
        with closing(self.client(hub)) as other:
            other.sendall(b'{"do":"stop"}\n')
            until(lambda: hub.commands.next(lambda state: None) == RunCommand("stop"))


def received_by(client):
    """Return the number of bytes that a client receives until its connection ends."""
    received = 0
    with suppress(ConnectionResetError):
        while data := client.recv(2**20):
            received += len(data)
    return received


class TestRuntimeFolder:
    def test_it_is_private(self, new_run, runtime_folder):
        with closing(Presence(new_run()).listener):
            assert stat.S_IMODE(runtime_folder.stat().st_mode) == 0o700

    @pytest.mark.parametrize("mode", [0o750, 0o707])
    def test_a_folder_open_to_others_is_rejected_and_ignored(self, new_run, runtime_folder, mode):
        path = new_run()
        presence = Presence(path)
        assert background_state(path) == "preparing"
        runtime_folder.chmod(mode)
        assert background_state(path) is None
        with pytest.raises(GaitsimError, match="0700"):
            start_detached(path)
        presence.listener.close()

    @pytest.mark.parametrize("kind", ["link", "relative", "missing parent"])
    def test_an_unusable_folder_is_rejected(self, new_run, tmp_path, monkeypatch, kind):
        folder = tmp_path / "here"
        if kind == "file":
            folder.touch()
        elif kind == "link":
            (tmp_path / "target").mkdir(0o700)
            folder.symlink_to(tmp_path / "target")
        elif kind == "relative":
            folder = Path("here")
        else:
            (tmp_path / "parent").touch()
            folder = tmp_path / "parent" / "here"
        monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(folder))
        with pytest.raises(GaitsimError, match="GAITSIM_RUNTIME_DIR"):
            start_detached(new_run())
        assert background_state(Path("run")) is None
        assert background_processes() == []

    def test_long_paths_work(self, new_run, tmp_path, monkeypatch):
        deep = Path(*(["a long name of a folder " * 5] * 3))
        monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(tmp_path / ("r" * 60) / ("s" * 60)))
        path = new_run(deep / "run", *SLOW, generations=100_000)
        start_detached(path)
        until(lambda: background_state(path) == "running")
        assert stop(path)


def test_another_process_with_the_same_id_is_not_signalled(new_run, runtime_folder):
    """A killed process leaves a status, and a check for a living process holds its lock."""
    path = new_run("run")
    sleeper = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
    status = {"run": str(path.resolve()), "pid": sleeper.pid, "state": "running"}
    file = runtime_file(path, STATUS)
    started = psutil.Process(sleeper.pid).create_time()
    with FileLock(create_runtime_folder() / runtime_file(path, LOCK).name):
        file.write_text(json.dumps(status | {"started": started - 100.0}))
        assert not stop(path, timeout=0.2)
        kill(path)
        assert sleeper.poll() is None
        file.write_text(json.dumps(status | {"started": started}))
        kill(path)
        assert sleeper.wait(timeout=60) == -signal.SIGKILL


def test_a_deleted_folder_is_reported_as_the_cause():
    """Its files disappear first, and the folder a moment later."""
    error, answers = (
        RunError("history.csv was deleted"),
        iter([None, RunError("the folder was deleted")]),
    )

    def check():
        if found := next(answers):
            raise found

    assert CommandQueue(check=check).cause(error).what == "the folder was deleted"
    assert CommandQueue(check=lambda: None).cause(error) is error


def test_a_full_runtime_folder_is_reported(new_run, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = new_run()
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(GaitsimError, match="No space left"):
        Presence(path)
    assert background_state(path) is None


def test_a_deleted_run_cannot_be_started(new_run):
    with pytest.raises(RunError, match="deleted or moved"):
        Presence(Path("gone"))
    with pytest.raises(GaitsimError, match="deleted or moved"):
        start_detached(Path("gone"))
    assert not Path("gone").exists()
    assert background_process(Path("gone")) is None
    assert not runtime_file(Path("gone"), LOCK).with_suffix(STATUS).exists()
