"""Progress, notices, files and errors as JSON lines on standard error."""

import json

import pytest

from gaitsim.errors import ExperimentError, error_from_dict


@pytest.fixture
def records(gaitsim, monkeypatch):
    """Return a function that runs a command and returns its records by kind, in order."""
    monkeypatch.setenv("GAITSIM_PROGRESS", "json")

    def run(*arguments, code=0):
        lines = gaitsim(*arguments, code=code).stderr.splitlines()
        found = {"progress": [], "notice": [], "result": [], "error": []}
        for line in map(json.loads, lines):
            found[line.pop("kind")].append(line)
        return found

    return run


def files_of(found):
    return [file for one in found["result"] for file in one["files"]]


@pytest.fixture
def walk(gaitsim, puppet_file):
    gaitsim("run", puppet_file, "--out", "runs/walk")
    return "walk"


@pytest.mark.parametrize(
    ("command", "unit", "total", "files"),
    [
        (["video", "--size", "160x120", "--fps", "2", "--no-intro"], "pictures", 3, 1),
        (["plot", "--kind", "all"], "kinds", None, None),
        (["verify"], "generations", 5, 0),
        (["analyse", "--perturb"], "kinds", None, 0),
        (["export"], None, None, 1),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_a_command_reports_progress_and_files(walk, records, tmp_path, command, unit, total, files):
    verb, *more = command
    found = records(verb, walk, *more)
    if unit is not None:
        last = found["progress"][-1]
        assert last["done"] == last["total"] == (total or last["total"])
        assert {one["unit"] for one in found["progress"]} == {unit}
    written = files_of(found)
    assert len(written) == files if files is not None else written
    assert all((tmp_path / file).is_file() for file in written)


def test_an_error_is_split_into_its_parts(walk, records):
    [error] = records("video", "nowhere", code=2)["error"]
    assert "nowhere" in error["what"]
    assert "walk" in error["allowed"]


def test_problems_of_an_experiment_have_keys(records, puppet_file):
    overrides = ["--set", "mutation.rat=1", "--set", "evolution.population=0"]
    [error] = records("run", puppet_file, *overrides, code=2)["error"]
    problem = error_from_dict(error)
    assert isinstance(problem, ExperimentError)
    assert [one.key for one in problem.problems] == ["evolution.population", "mutation.rat"]


def test_an_unknown_value_is_rejected(gaitsim, monkeypatch):
    monkeypatch.setenv("GAITSIM_PROGRESS", "yes")
    error = gaitsim("runs", code=2).stderr
    assert "'yes'" in error
    assert "GAITSIM_PROGRESS" in error
