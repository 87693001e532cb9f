"""Background runs on the command line."""

import json
import os
import signal
from pathlib import Path

import pytest
from waiting import until

from gaitsim.live.process import background_state, send
from gaitsim.live.protocol import RunCommand
from gaitsim.storage.background import background_process
from gaitsim.storage.snapshot import RunSnapshot

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="needs Unix sockets"),
    pytest.mark.usefixtures("here"),
]
LONG = ("--generations", 100_000, "--set", "organism.pause=0.01")


@pytest.fixture
def detached(gaitsim, puppet_file):
    """Return a function that starts a run in the background."""

    def detached(name="run", *options):
        gaitsim("run", puppet_file, "--detach", "--out", name, *(options or LONG))
        return Path(name)

    return detached


@pytest.mark.slow
def test_a_detached_run_is_watched_and_stopped(gaitsim, detached, start):
    path = detached()
    until(lambda: RunSnapshot(path).generation > 1)
    refused = gaitsim("resume", path, "--detach", code=2).stderr
    assert f"in process {background_process(path).pid}" in refused
    assert "gaitsim attach run" in refused
    assert "gaitsim stop run" in gaitsim("resume", path, code=2).stderr
    assert "in the background" in gaitsim("runs", "--delete", path, "--yes", code=2).stderr
    assert "running" in gaitsim("runs", ".").stdout
    assert "in the background: running" in gaitsim("show", path).stdout
    watching = start("attach", path, "--json")
    rows = [json.loads(watching.stdout.readline()) for _ in range(3)]
    assert [row["generation"] - rows[0]["generation"] for row in rows] == [0, 1, 2]
    assert {*rows[0]} == {*RunSnapshot(path).history}
    watching.send_signal(signal.SIGINT)
    assert "gaitsim stop run" in watching.communicate()[1]
    assert watching.returncode == 130
    assert background_state(path) == "running"
    assert "gaitsim resume run" in gaitsim("stop", path).stdout
    assert background_state(path) is None
    assert "is not evolving" in gaitsim("stop", path, code=2).stderr
    assert "gaitsim resume run --detach" in gaitsim("attach", path, code=2).stderr
    done = RunSnapshot(path)
    options = ("--generations", done.generation, "--set", "organism.pause=0.01")
    whole = gaitsim("run", "puppet.toml", "--out", "whole", *options)
    assert RunSnapshot(Path("whole")).fingerprint() == done.fingerprint(), whole.stderr


@pytest.mark.slow
def test_all_runs_are_stopped_in_a_folder_or_everywhere(gaitsim, detached, monkeypatch):
    monkeypatch.setenv("GAITSIM_BACKGROUND_RUNS", "1")
    paths = [detached(f"{folder}/{name}") for folder in ("a", "b") for name in "xy"]
    states = [background_state(path) for path in paths]
    assert states[1:] == ["queued"] * 3
    listed = gaitsim("runs", "a", "--json").stdout.splitlines()
    assert json.loads(listed[1])["state"] == "queued"
    assert "in the background" in gaitsim("runs", "--delete", "b/y", "--yes", code=2).stderr
    stopped = gaitsim("stop", "--all", "a", "--json").stdout.splitlines()
    assert {json.loads(line)["run"] for line in stopped} == {"a/x", "a/y"}
    assert [background_state(path) is None for path in paths] == [True, True, False, False]
    gaitsim("stop", "--all")
    assert not any(background_state(path) for path in paths)
    assert "No run" in gaitsim("stop", "--all").stdout


def test_stopping_all_reports_an_unusable_runtime_folder(gaitsim, tmp_path, monkeypatch):
    monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(tmp_path))
    tmp_path.chmod(0o755)
    assert "GAITSIM_RUNTIME_DIR" in gaitsim("stop", "--all", code=2).stderr


def test_a_paused_run_continues_by_resume(gaitsim, detached):
    path = detached()
    send(path, RunCommand("pause"))
    until(lambda: background_state(path) == "paused")
    assert "paused" in gaitsim("runs", ".").stdout
    refused = gaitsim("resume", path, "--detach", "--generations", 200_000, code=2).stderr
    assert "is paused in the background" in refused
    gaitsim("resume", path, "--detach")
    until(lambda: background_state(path) == "running")
