"""Run folders are created, found and listed."""

import errno
import json
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from run_helpers import names

from gaitsim.errors import RunError
from gaitsim.storage import compatibility
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.folder import find_run, list_runs
from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import delete_run
from gaitsim.storage.snapshot import RunSnapshot

pytestmark = pytest.mark.usefixtures("here")


def test_a_new_run_holds_its_experiment_and_empty_folders(puppet):
    path = create_run(puppet())
    assert path == Path("runs/puppet")
    assert names(path) == {"experiment.toml", "champions", "exports"}
    assert RunSnapshot(path).experiment == puppet()
    assert names(Path("runs")) == {"puppet"}


def test_a_name_that_is_taken_gets_a_number(puppet):
    assert [create_run(puppet()).name for _ in range(3)] == ["puppet", "puppet-2", "puppet-3"]
    out = Path("new/deep/out")
    assert create_run(puppet(), out) == out
    assert create_run(puppet(), out) == Path("new/deep/out-2")
    Path("file").touch()
    assert create_run(puppet(), Path("file")) == Path("file-2")
    Path("link").symlink_to("nowhere")
    assert create_run(puppet(), Path("link")) == Path("link-2")
    assert Path("file").read_bytes() == b""


def test_runs_that_start_at_the_same_time_get_separate_folders(puppet):
    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(create_run, [puppet() for _ in range(16)]))
    assert len(set(paths)) == 16
    assert names(Path("runs")) == {path.name for path in paths}


@pytest.mark.parametrize("out", [".", "..", "/", "a/.."])
def test_a_folder_that_cannot_be_created_is_an_error(puppet, out):
    before = names(Path("..").resolve())
    with pytest.raises(RunError, match="already exists"):
        create_run(puppet(), Path(out))
    assert names(Path()) == set()
    assert names(Path("..").resolve()) == before


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS])
@pytest.mark.parametrize("number", range(6))
def test_a_run_that_cannot_be_created_leaves_nothing(puppet, monkeypatch, number, code):
    steps = iter(range(100))

    def failing(real):
        def stub(*arguments, **options):
            if next(steps) == number:
                raise OSError(code, os.strerror(code))
            return real(*arguments, **options)

        return stub

    Path("runs").mkdir()
    for owner, name in [(os, "fsync"), (Path, "mkdir"), (Path, "replace"), (Path, "rename")]:
        monkeypatch.setattr(owner, name, failing(getattr(owner, name)))
    with pytest.raises(RunError, match=os.strerror(code)) as error:
        create_run(puppet())
    assert error.value.remedy
    assert names(Path("runs")) == set()


def test_a_population_too_large_for_a_checkpoint_is_an_error(puppet, monkeypatch):
    monkeypatch.setattr(compatibility, "MAX_BYTES", 1000)
    create_run(puppet("evolution.population=20"))
    with pytest.raises(RunError, match="21 individuals with 3 genes are too many") as error:
        create_run(puppet("evolution.population=21"))
    assert error.value.allowed == "evolution.population up to 20"


def test_a_run_is_found_by_name_and_by_path(puppet):
    path = create_run(puppet())
    assert find_run("puppet") == find_run("runs/puppet") == path
    assert find_run(str(path.resolve())) == path.resolve()
    assert find_run("runs/puppet/") == path


@pytest.mark.parametrize("name", ["nobody", "", "a" * 300, "a\0b", "runs/puppet/experiment.toml"])
def test_other_folders_and_names_are_not_runs(puppet, name):
    with pytest.raises(RunError, match="there is no run") as error:
        find_run(name)
    assert error.value.allowed == ""
    assert "runs/ in this folder has no runs yet" in error.value.what
    create_run(puppet())
    with pytest.raises(RunError, match="there is no run") as error:
        find_run(name)
    assert error.value.allowed == "puppet"


def test_a_folder_without_an_experiment_is_not_a_run():
    Path("runs/empty").mkdir(parents=True)
    for name in ("empty", "runs/empty"):
        with pytest.raises(RunError, match="is not a run: it has no"):
            find_run(name)


def test_runs_are_listed_oldest_first(puppet):
    assert list_runs(Path("runs")) == []
    paths = [create_run(puppet()) for _ in range(3)]
    for age, path in zip([5, 9, 5], paths, strict=True):
        os.utime(path / "experiment.toml", (1e9 - age, 1e9 - age))
    Path("runs/file").touch()
    Path("runs/other").mkdir()
    Path("runs/broken").symlink_to("nowhere")
    shutil.copytree(paths[0], "runs/.gaitsim-1234.partial")  # left by a killed program
    assert [path.name for path in list_runs(Path("runs"))] == ["puppet-2", "puppet", "puppet-3"]
    with pytest.raises(RunError, match="cannot list runs/file"):
        list_runs(Path("runs/file"))


@pytest.fixture
def run(puppet, tmp_path):
    return create_run(puppet(), tmp_path / "runs" / "walk")


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


OLD = Path(__file__).parents[1] / "fixtures" / "run-format-1"  # written by gaitsim 0.1.0


@pytest.fixture
def old(tmp_path):
    return Path(shutil.copytree(OLD, tmp_path / "runs" / "old"))


def files(path):
    return {item.name: item.read_bytes() for item in path.rglob("*") if item.is_file()}


@pytest.mark.parametrize("command", ["show", "resume"])
def test_a_command_says_who_wrote_it_and_changes_nothing(gaitsim, old, command):
    before = files(old)
    done = gaitsim(command, "old", code=2)
    assert "was written by gaitsim 0.1.0 in the older format 1" in done.stderr
    assert "start a new run" in done.stderr
    after = {name: data for name, data in files(old).items() if not name.startswith(".lock")}
    assert after == before


def test_it_is_listed_as_such(gaitsim, old):
    (row,) = map(json.loads, gaitsim("runs", "--json").stdout.splitlines())
    assert (row["run"], row["state"]) == ("old", "older format")
    assert "older format" in gaitsim("runs").stdout
