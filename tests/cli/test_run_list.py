"""`gaitsim runs` with queries and tags, `gaitsim tag` and `gaitsim trash`."""

import json
import shutil

import pytest

from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import read_tags, write_tags


@pytest.fixture(autouse=True)
def config(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


@pytest.fixture
def runs(gaitsim, puppet_file, tmp_path, once):
    """Return the folder of three runs: two of five generations, one of three."""

    def create():
        for name, count in (("a", 5), ("b", 3)):
            gaitsim("run", puppet_file, "--generations", count, "--out", f"runs/{name}")
        shutil.copytree(tmp_path / "runs/a", tmp_path / "runs/c")
        write_tags(tmp_path / "runs/a", ["good"])

    return once("three runs", tmp_path / "runs", create)


def listed(done):
    return [json.loads(line)["run"] for line in done.stdout.splitlines()]


def test_a_query_chooses_runs_in_the_order_of_a_key(gaitsim, runs):
    chosen = ("--where", "puppet generation>=4", "--sort", "-name", "--json")
    assert listed(gaitsim("runs", *chosen)) == ["c", "a"]
    assert listed(gaitsim("runs", "--where", "tag:good", "--json")) == ["a"]
    assert "No run in runs matches 'nobody'." in gaitsim("runs", "--where", "nobody").stdout


def test_json_has_the_values_of_a_run_or_of_the_chosen_keys(gaitsim, runs):
    found = json.loads(gaitsim("runs", "--where", "name=a", "--json").stdout)
    assert (found["tags"], found["generation"], found["stage"]) == (["good"], 5, 1)
    assert found["evaluations"] > found["generation"]
    columns = "tag, evolution.generations,reach"
    found = json.loads(
        gaitsim("runs", "--where", "a", "--columns", columns, "--json").stdout.splitlines()[0]
    )
    assert {*found} == {"run", "tag", "evolution.generations", "reach"}
    assert found["evolution.generations"] == 5


@pytest.mark.parametrize(
    ("options", "place"),
    [
        (("--where", "scor>1"), "--where"),
        (("--columns", "name,scor"), "--columns"),
        (("--sort", "-scor"), "--sort"),
    ],
)
def test_a_wrong_key_or_value_names_its_option(gaitsim, runs, options, place):
    error = gaitsim("runs", *options, code=2).stderr
    assert f"where:   {place}" in error
    assert "allowed:" in error


def test_tags_of_one_run_are_added_shown_and_removed(gaitsim, runs):
    assert gaitsim("tag", "a", "straight", "Größe").stdout == "runs/a: Größe, good, straight\n"
    assert gaitsim("tag", "a").stdout == "Größe\ngood\nstraight\n"
    assert gaitsim("tag", "a", "--remove", "good").stdout == "runs/a: Größe, straight\n"
    assert "has no tags" in gaitsim("tag", "b").stderr
    shown = json.loads(gaitsim("tag", "a", "--json").stdout)
    assert shown == {"run": "runs/a", "tags": ["Größe", "straight"]}
    assert json.loads(gaitsim("show", "a", "--json").stdout)["tags"] == shown["tags"]
    assert "\ntags: Größe, straight\n" in gaitsim("show", "a").stdout
    assert "invalid tag: 'a b'" in gaitsim("tag", "a", "a b", code=2).stderr
    assert "good" not in gaitsim("runs", "--columns", "name,tag").stdout


def test_matching_runs_are_tagged_after_a_question(gaitsim, runs, monkeypatch):
    chosen = ("runs", "--where", "generation=5", "--tag", "new", "--untag", "good")
    assert "add --yes" in gaitsim(*chosen, code=2).stderr
    asked = []
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("typer.confirm", asked.append)
    assert "Nothing was changed" in gaitsim(*chosen).stderr
    assert asked == ["Change the tags of runs/a, runs/c: +new -good?"]
    assert gaitsim(*chosen, "--yes").stdout == "runs/a: new\nruns/c: new\n"
    assert [read_tags(runs / name) for name in "abc"] == [("new",), (), ("new",)]
    assert gaitsim("runs", "--where", "name=b", "--tag", "x").stdout == "runs/b: x\n"
    assert "No run matches" in gaitsim("runs", "--where", "nobody", "--tag", "x").stderr
    assert "no query chooses" in gaitsim("runs", "--tag", "x", code=2).stderr


def test_matching_runs_are_deleted_but_not_those_that_evolve(gaitsim, runs):
    chosen = ("runs", "--where", "generation=5", "--delete-matching")
    assert "add --yes" in gaitsim(*chosen, code=2).stderr
    assert "no query chooses" in gaitsim("runs", "--delete-matching", "--yes", code=2).stderr
    lock = RunLock(runs / "a")
    done = gaitsim(*chosen, "--yes")
    assert (done.stdout, done.stderr) == (
        "runs/c: in the trash\n",
        "runs/a is kept, because it is running.\n",
    )
    lock.release()
    assert gaitsim(*chosen, "--yes", "--permanently").stdout == "runs/a: deleted\n"
    assert [line.split()[0] for line in gaitsim("trash", "list").stdout.splitlines()[1:]] == ["c"]


def test_the_trash_is_listed_restored_and_emptied(gaitsim, runs):
    assert gaitsim("trash", "list").stdout == "The trash of runs is empty.\n"
    assert "none; the trash is empty" in gaitsim("trash", "restore", "a", code=2).stderr
    gaitsim("runs", "--delete", "a", "--delete", "b", "--yes")
    assert listed(gaitsim("trash", "list", "--json")) == ["b", "a"]
    assert "did you mean" not in gaitsim("trash", "restore", "zzz", code=2).stderr
    assert "an unused name" in gaitsim("trash", "restore", "a", "--name", "c", code=2).stderr
    assert gaitsim("trash", "restore", "a", "--name", "d").stdout == "runs/d: restored\n"
    assert "add --yes" in gaitsim("trash", "empty", code=2).stderr
    older = ("trash", "empty", "--older-than", 1)
    assert gaitsim(*older).stdout == "0 runs deleted permanently\n"
    assert json.loads(gaitsim("trash", "empty", "--yes", "--json").stdout) == {"deleted": "b"}


def test_watching_prints_the_evolving_runs_once_into_a_pipe(gaitsim, runs):
    assert gaitsim("runs", "--watch").stdout == "No run is evolving.\n"
    assert gaitsim("runs", "--watch", "--json").stdout == ""
    lock = RunLock(runs / "a")
    (row,) = gaitsim("runs", "--watch").stdout.splitlines()[1:]
    lock.release()
    name, state, *_, memory, unit = row.split()
    assert (name, state, unit) == ("a", "running", "MB")
    assert float(memory.replace(",", "")) > 10
