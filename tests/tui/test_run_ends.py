"""The app reports the ends of background runs on every screen."""

import json

import pytest
from run_helpers import continue_run

from gaitsim.errors import RunError
from gaitsim.storage.background import (
    FAILURE,
    BackgroundProcess,
    create_runtime_folder,
    identity,
    runtime_file,
)
from gaitsim.storage.creation import create_run
from gaitsim.tui import run_ends
from gaitsim.tui.config import Config
from gaitsim.tui.run_ends import RunEnds, desktop_notification


@pytest.fixture
def evolving(monkeypatch):
    """Return the set of runs that seem to evolve in the background."""
    runs = set()

    def found(folder):
        return [BackgroundProcess(run.resolve(), 1, "running", 0.0) for run in runs]

    monkeypatch.setattr(run_ends, "processes_in", found)
    return runs


@pytest.fixture
def run(here, puppet):
    """Return a run of five generations, of which three are finished."""
    path = create_run(puppet("evolution.generations=5"))
    continue_run(path, 3)
    return path


def fail(run, monkeypatch, tmp_path):
    monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(tmp_path / "runtime"))
    create_runtime_folder()
    error = RunError("the disk is full\x1b]0;" + "x" * 500, remedy="free some space").to_dict()
    data = {"error": error, "identity": identity(run)}
    runtime_file(run, FAILURE).write_text(json.dumps(data))


def test_finished_and_failed_runs_are_reported_once(run, evolving, monkeypatch, tmp_path):
    ends = RunEnds(run.parent)
    evolving.add(run)
    assert ends.poll() == []
    assert ends.poll() == []
    evolving.clear()
    assert ends.poll() == []  # stopped
    evolving.add(run)
    ends.poll()
    continue_run(run)
    evolving.clear()
    (end,) = ends.poll()
    assert (end.title, end.failed) == ("puppet finished", False)
    assert end.text.startswith("generation 5, best ")
    assert ends.poll() == []
    evolving.add(run)
    ends.poll()
    fail(run, monkeypatch, tmp_path)
    evolving.clear()
    (end,) = ends.poll()
    assert (end.title, end.failed) == ("puppet failed", True)
    assert end.text.startswith("the disk is full\\x1b]0;x")
    assert len(end.text) <= 100  # a notification must not cover the screen


def test_a_deleted_run_is_not_reported(run, evolving):
    ends = RunEnds(run.parent)
    evolving.add(run)
    ends.poll()
    run.rename(run.with_name("other"))
    evolving.clear()
    assert ends.poll() == []


def test_a_desktop_notification_has_no_other_control_characters():
    text = desktop_notification("a\x1b]0;b\x07c\n\u202ed\x9b" + "x" * 1000)
    assert text.startswith("\x1b]9;gaitsim: a ]0;b c  d ")
    assert text.endswith("x\x07\x07")
    assert text[1:-2].isprintable()
    assert len(text) < 300


@pytest.mark.sampled
@pytest.mark.parametrize("wanted", [True, False])
async def test_the_end_is_shown_on_any_screen_and_rings(
    run, evolving, drive, monkeypatch, tmp_path, wanted
):
    evolving.add(run)
    async with drive(config=Config(tmp_path / "config.toml", notify=wanted)) as driver:
        written = []
        monkeypatch.setattr(driver.app._driver, "write", written.append)
        monkeypatch.setattr(type(driver.app), "is_headless", False)
        await driver.press("question_mark")
        await driver.until(lambda: driver.app._ends._known)
        continue_run(run)
        evolving.clear()
        await driver.until(lambda: "puppet finished" in driver.notifications())
        rings = [text for text in written if text.startswith("\x1b]9;gaitsim: puppet finished")]
        assert len(rings) == wanted
