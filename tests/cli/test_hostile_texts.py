"""Untrusted texts never reach the terminal as control sequences or markup."""

import os
import sys

import pytest
from hostile_texts import CHANGES, ENTRIES, HOSTILE, MARKUP, NAME, PACKAGE, raw

from gaitsim.cli import main
from gaitsim.storage.lock import RunLock


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


@pytest.mark.parametrize("styled", [True], indirect=True)
@pytest.mark.parametrize("file", ["experiment.toml", "provenance.json", ".lock-owner"])
def test_texts_in_the_files_of_a_run_are_escaped(file, puppet_run, quiet):
    run = puppet_run().path
    escaped = HOSTILE.replace("\\", "\\\\")
    for char in "\x1b\x07\x9b\u202e":
        escaped = escaped.replace(char, f"\\u{ord(char):04x}")
    lock = RunLock(run) if file == ".lock-owner" else None
    old, new = {
        "experiment.toml": ("puppet-reach", escaped),
        "provenance.json": ("gaitsim-puppets", escaped),
        ".lock-owner": ("process", HOSTILE),
    }[file]
    text = (run / file).read_text()
    assert old in text
    (run / file).write_text(text.replace(old, new))
    said = ""
    for command in (
        ("runs", "."),
        ("show", run),
        ("verify", run),
        ("differences", run, run),
        ("resume", run, "--generations", 6, "--workers", 1),
    ):
        said += quiet(*command, codes=(0, 1, 2))
    if lock is not None:
        lock.release()
    assert "\\u202e[bold]b[/nope]" in said
