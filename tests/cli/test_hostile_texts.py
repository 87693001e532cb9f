"""Untrusted texts never reach the terminal as control sequences or markup."""

import os
import sys

import pytest
from hostile_texts import CHANGES, ENTRIES, MARKUP, NAME, PACKAGE, raw

from gaitsim.cli import main


@pytest.fixture(params=[False, True], ids=["piped", "terminal"])
def styled(request, monkeypatch):
    """Return whether the output is a terminal, with colours and a live view."""
    if request.param:
        monkeypatch.setenv("FORCE_COLOR", "1")
        monkeypatch.setenv("COLUMNS", "1000")
    return request.param


@pytest.fixture
def quiet(tmp_path, puppets, styled, monkeypatch, capsys):
    """Return a function that runs a command and checks that its output is escaped."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments, codes=(0,)):
        monkeypatch.setattr(sys, "argv", ["gaitsim", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        assert (ended.value.code or 0) in codes, said.err
        for text in said:
            assert not raw(text, styled)
        return said.out + said.err

    return run


@pytest.mark.sampled
def test_texts_of_plugins_and_names_of_folders_are_escaped(
    install, puppet_file, monkeypatch, styled, quiet
):
    folder = install("wicked", PACKAGE, ENTRIES)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    options = [f"--set={change}" for change in CHANGES]
    run = f"runs/{NAME}"
    said = quiet("run", puppet_file, "--workers", 1, "--out", run, *options)
    assert ("\x1b[" in said) is styled  # colours stay
    assert MARKUP in said
    for command in (
        ("runs",),
        ("show", run),
        ("analyse", run),
        ("differences", run, run),
        ("plugins", "show", "wicked"),
        ("plugins", "show", "wicked-score"),
        ("experiments", "show", f"{run}/experiment.toml"),
        ("plot", run, "--kind", "terms"),
        ("play", run, "--at", "0"),
        ("export", run, "--format", "csv"),
    ):
        assert "[bold]b" in quiet(*command)
    for command in (("runs",), ("show", run), ("differences", run, run)):
        assert "\\u202e" in quiet(*command, "--json")
    broken = ("--set=selection.plugin=wicked-broken", "--generations=7", "--workers=1")
    assert "[bold]b" in quiet("resume", run, *broken, codes=(2,))
    quiet("runs", "--delete", run, "--yes")
