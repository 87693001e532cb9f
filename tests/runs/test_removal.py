"""Deleting runs."""

import errno
import os
import sys
from pathlib import Path

import pytest

from gaitsim.errors import RunError
from gaitsim.runs.creation import create_run
from gaitsim.runs.files.folder import list_runs
from gaitsim.runs.lock import RunLock
from gaitsim.runs.manage import delete_run


@pytest.fixture
def run(puppet, tmp_path):
    return create_run(puppet(), tmp_path / "runs" / "walk")


def test_nothing_is_left(run):
    (run / "exports" / "gait.csv").write_text("1")
    delete_run(run)
    assert list(run.parent.iterdir()) == []


def test_one_error_leaves_nothing_behind(run, monkeypatch):
    real, calls = os.unlink, []

    def unlink(*arguments, **options):
        calls.append(arguments)
        if len(calls) == 1:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        real(*arguments, **options)

    monkeypatch.setattr(os, "unlink", unlink)
    delete_run(run)
    assert len(calls) > 1
    assert list(run.parent.iterdir()) == []


def test_the_current_folder_can_be_deleted(run, monkeypatch):
    monkeypatch.chdir(run)
    delete_run(Path())
    assert list(run.parent.iterdir()) == []


def test_a_run_that_is_being_written_is_not_deleted(run):
    lock = RunLock(run)
    with pytest.raises(RunError, match="being written"):
        delete_run(run)
    lock.release()
    assert list_runs(run.parent) == [run]


@pytest.mark.parametrize("make", ["mkdir", "touch"])
def test_other_folders_are_not_deleted(tmp_path, make):
    path = tmp_path / "thing"
    getattr(path, make)()
    with pytest.raises(RunError, match="not a run"):
        delete_run(path)
    assert path.exists()


def test_a_link_to_a_run_is_not_followed(run, tmp_path):
    link = tmp_path / "link"
    link.symlink_to(run)
    with pytest.raises(RunError, match="a symbolic link to a run"):
        delete_run(link)
    assert list_runs(run.parent) == [run]


@pytest.mark.skipif(os.name == "nt", reason="paths may not be as long")
@pytest.mark.skipif(sys.version_info >= (3, 13), reason="Python deletes folders of any depth")
def test_folders_that_are_too_deep_are_one_message(run):
    deep = [run / ("d/" * (number + 1)) for number in range(1100)]
    for folder in deep:
        folder.mkdir()
    with pytest.raises(RunError, match="its folders are nested too deeply") as refused:
        delete_run(run)
    left = Path(refused.value.where)
    assert list_runs(left.parent) == []
    for folder in reversed(deep):
        (left / folder.relative_to(run)).rmdir()


def test_links_are_deleted_without_their_targets(run, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "file").write_text("mine")
    (run / "exports").rmdir()
    (run / "exports").symlink_to(outside)
    (run / ".lock-owner").symlink_to(outside / "file")
    delete_run(run)
    assert list(run.parent.iterdir()) == []
    assert (outside / "file").read_text() == "mine"
