"""Run folders are created, found and listed."""

import errno
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from run_helpers import names

from gaitsim.errors import RunError
from gaitsim.runs import compatibility
from gaitsim.runs.creation import create_run
from gaitsim.runs.files.folder import find_run, list_runs
from gaitsim.runs.snapshot import RunSnapshot

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


def test_a_run_without_its_experiment_has_its_own_message(whole):
    (whole.path / "experiment.toml").unlink()
    with pytest.raises(RunError, match=r"the run whole has lost its experiment\.toml"):
        find_run("whole")
