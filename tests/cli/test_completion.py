"""Completions that a shell receives at Tab, requested as by its completion script."""

from pathlib import Path

import pytest
from typer.main import get_command

from gaitsim.cli.app import app
from gaitsim.storage.manage import trash_run, write_tags


@pytest.fixture
def offered(tmp_path, puppets, monkeypatch, capsys):
    """Return a function that returns bash's completions of the last word of a command line."""
    monkeypatch.chdir(tmp_path)

    def complete(*words):
        monkeypatch.setenv("COMP_WORDS", " ".join(["gaitsim", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        monkeypatch.setenv("_GAITSIM_COMPLETE", "complete_bash")
        with pytest.raises(SystemExit) as ended:
            get_command(app).main([], prog_name="gaitsim")
        assert not ended.value.code
        return capsys.readouterr().out.split("\n")[:-1]

    return complete


@pytest.fixture
def run_folders(tmp_path):
    """Return a function that creates run folders with given names."""

    def make(*names):
        for name in names:
            folder = tmp_path / "runs" / name
            folder.mkdir(parents=True)
            (folder / "experiment.toml").touch()

    return make


def test_tags_keys_and_deleted_runs_are_offered(offered, run_folders):
    run_folders("a", "b")
    write_tags(Path("runs/a"), ["good", "straight", "a$b"])
    trash_run(Path("runs/b"))
    assert offered("tag", "a", "go") == ["good"]
    assert offered("runs", "--where", "x", "--tag", "") == ["good", "straight"]
    assert offered("runs", "--sort", "gen") == ["generation", "generations"]
    assert offered("trash", "restore", "") == ["b"]


def test_commands_flags_and_choices_are_offered(offered):
    assert offered("pl") == ["plot", "play", "plugins", "playground"]
    assert offered("plugins", "sh") == ["show"]
    assert offered("video", "spider", "--fp") == ["--fps"]
    assert offered("plot", "spider", "--kind", "fo") == ["footfall"]
    assert "--out" in offered("plot", "spider", "--kind", "nonsense", "--o")


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["run", "hexapod-a"], "hexapod-atlas"),
        (["experiments", "show", "walker-w"], "walker-worlds"),
        (["steer", "fly-st"], "fly-steer"),
        (["study", "millipede-o"], "millipede-operators"),
        (["plugins", "show", "trunc"], "truncation"),
    ],
)
def test_installed_names_are_offered(offered, words, name):
    assert name in offered(*words)


@pytest.mark.parametrize(
    "words",
    [
        ["show"],
        ["differences", "first"],
        ["runs", "--delete"],
        ["run", "spider", "--from"],
    ],
)
def test_runs_are_offered(offered, run_folders, words):
    run_folders("first", "second.b-2")
    assert set(offered(*words, "")) == {"first", "second.b-2"}
    assert offered(*words, "s") == ["second.b-2"]


def test_names_with_special_characters_of_shells_are_not_offered(offered, run_folders):
    run_folders("good", "$(touch x)", "`touch x`", "a b", "*", "q'", 'd"', "-o", ";x", "a\nb")
    assert offered("show", "") == ["good"]
