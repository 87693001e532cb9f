"""Deleted runs stay in the trash for 30 days."""

import errno
import os
import time
from pathlib import Path

import pytest
from run_helpers import names

from gaitsim.errors import RunError
from gaitsim.storage import manage
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.folder import list_runs
from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import (
    KEPT,
    empty_trash,
    list_trash,
    restore_run,
    trash_run,
    write_note,
)

pytestmark = pytest.mark.usefixtures("here")
ROOT = Path("runs")


@pytest.fixture
def run(puppet, here):
    path = create_run(puppet())
    write_note(path, "mine")
    return path


def test_a_run_returns_from_the_trash_unchanged(run):
    before = names(run)
    trashed = trash_run(run)
    assert (trashed.name, trashed.root) == ("puppet", run.parent.resolve())
    assert list_runs(ROOT) == []
    assert [one.name for one in list_trash(ROOT)] == ["puppet"]
    assert abs(list_trash(ROOT)[0].deleted - trashed.deleted) < 1e-5
    assert restore_run(list_trash(ROOT)[0]) == run
    assert names(run) - {".lock", ".lock-owner"} == before
    assert list_trash(ROOT) == []
    assert names(ROOT / ".trash") == set()


def test_runs_of_the_same_name_are_kept_apart_latest_first(puppet, run):
    trash_run(run)
    write_note(create_run(puppet()), "second")
    trash_run(run)
    found = list_trash(ROOT)
    assert [(one.path / "note.txt").read_text() for one in found] == ["second\n", "mine\n"]


def test_a_run_is_not_restored_over_another(puppet, run):
    trashed = trash_run(run)
    create_run(puppet())
    with pytest.raises(RunError, match="puppet already exists in") as error:
        restore_run(trashed)
    assert error.value.allowed == "an unused name, such as puppet-2"
    with pytest.raises(RunError, match="invalid name"):
        restore_run(trashed, "../x")
    assert restore_run(trashed, "puppet-2").name == "puppet-2"
    with pytest.raises(RunError, match="is not a run"):
        restore_run(trashed, "again")


def test_the_trash_is_emptied_by_age(puppet, run, monkeypatch):
    now = time.time()
    monkeypatch.setattr(time, "time", lambda: now - KEPT - 1)
    trash_run(run)
    monkeypatch.setattr(time, "time", lambda: now - KEPT + 60)
    trash_run(create_run(puppet(), ROOT / "younger"))
    monkeypatch.setattr(time, "time", lambda: now)
    trash_run(create_run(puppet(), ROOT / "youngest"))
    assert [one.name for one in list_trash(ROOT)] == ["youngest", "younger"]
    assert [one.name for one in empty_trash(ROOT, older_than=60)] == ["younger"]
    assert [one.name for one in empty_trash(ROOT)] == ["youngest"]
    assert names(ROOT / ".trash") == set()
    assert empty_trash(ROOT) == []


def test_a_run_that_is_being_written_is_not_moved(run):
    lock = RunLock(run)
    with pytest.raises(RunError, match="being written"):
        trash_run(run)
    lock.release()
    assert list_runs(ROOT) == [run]
    assert names(ROOT / ".trash") == set()


def test_links_are_not_followed(run, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (ROOT / ".trash").symlink_to(outside)
    with pytest.raises(RunError, match="it is a symbolic link"):
        trash_run(run)
    assert (list_trash(ROOT), empty_trash(ROOT)) == ([], [])
    (ROOT / ".trash").unlink()
    link = ROOT / "link"
    link.symlink_to(run)
    with pytest.raises(RunError, match="a symbolic link to a run"):
        trash_run(link)
    trash_run(run)
    entry = next((ROOT / ".trash").iterdir())
    (entry / "kept").symlink_to(outside)
    empty_trash(ROOT)
    assert outside.is_dir()


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS])
@pytest.mark.parametrize("method", ["mkdir", "rename"])
def test_a_run_that_cannot_be_moved_stays(run, monkeypatch, method, code):
    def fail(*arguments, **options):
        raise OSError(code, os.strerror(code))

    with monkeypatch.context() as patch:
        patch.setattr(Path, method, fail)
        with pytest.raises(RunError, match=os.strerror(code)) as error:
            trash_run(run)
    assert error.value.remedy.endswith("delete the run permanently")
    assert list_runs(ROOT) == [run]
    assert list_trash(ROOT) == []


def test_a_kill_while_the_trash_is_emptied_leaves_no_half_run(run, monkeypatch):
    trash_run(run)

    def kill(draft):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(manage, "remove", kill)
        with pytest.raises(KeyboardInterrupt):
            empty_trash(ROOT)
    assert list_trash(ROOT) == []
    assert len(names(ROOT / ".trash")) == 1
    assert empty_trash(ROOT) == []
    assert names(ROOT / ".trash") == set()


def test_other_folders_in_the_trash_are_left_alone(run):
    trash_run(run)
    (ROOT / ".trash" / "mine").mkdir()
    (ROOT / ".trash" / "file").touch()
    empty_trash(ROOT)
    assert names(ROOT / ".trash") == {"mine", "file"}
