"""Attack every file of a run, and run every command that opens runs.

Each case ends with a result or with one message, without a traceback, a hang, or a change of
anything outside the run folder.
"""

import shutil
import signal
import sys
from itertools import cycle

import pytest
from hostile import CASES, FILES, attacked, make_template

from conftest import PUPPETS
from gaitsim.cli import main

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc")

PATIENCE = 60  # seconds until the signal of an alarm ends a command that hangs

COMMANDS = {
    "runs": ("runs",),
    "show": ("show", "victim"),
    "verify": ("verify", "victim", "--workers", "1"),
    "plot": ("plot", "victim", "--kind", "fitness"),
    "analyse": ("analyse", "victim"),
    "export": ("export", "victim"),
    "play": ("play", "victim", "--at", "0"),
    "differences": ("differences", "victim", "other"),
    "fork": ("fork", "victim"),
    "resume": ("resume", "victim", "--generations", "6", "--workers", "1"),
    "run --from": ("run", "puppet.toml", "--from", "victim", "--generations", "1"),
    "run FILE": ("run", "runs/victim/experiment.toml", "--generations", "1", "--workers", "1"),
    "note": ("note", "victim", "It drags two legs."),
    "rename": ("rename", "victim", "renamed"),
    "runs --delete": ("runs", "--delete", "victim", "--yes"),
}


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    """Return a folder with a run that has every file, a second run, and an experiment file."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PUPPETS))
        folder = tmp_path_factory.mktemp("hostile")
        patch.chdir(folder)
        make_template(lambda *arguments: call(patch, *arguments))
        yield folder


def call(patch, *arguments):
    """Run a command in this process; return its exit code."""
    patch.setattr(sys, "argv", ["gaitsim", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return ended.value.code or 0


def contents(folder):
    """Return the content of a folder, without the attacked run and the output of commands."""
    return {
        path: (path.read_bytes() if path.is_file() else b"", path.stat().st_mtime_ns)
        for part in ("outside", "runs/other", "puppet.toml")
        for path in (folder / part, *(folder / part).rglob("*"))
    } | {folder: (b"", len([*folder.iterdir()]))}


def problems(patch, capsys, folder, arguments):
    """Return the problems with how a command ends in an attacked folder."""
    patch.chdir(folder)
    before = contents(folder)
    capsys.readouterr()
    signal.alarm(PATIENCE)
    try:
        code = call(patch, *arguments)
    except Exception as error:
        return [f"raised {type(error).__name__}: {error}"[:300]]
    finally:
        signal.alarm(0)
    written = capsys.readouterr()
    found = []
    if code not in ((0, 1, 2) if arguments[0] == "verify" else (0, 2)):
        found.append(f"ended with {code}")
    if code == 2 and written.err.count("Error: ") != 1:
        found.append(f"said {written.err!r}")
    if "Traceback" in written.out + written.err:
        found.append("printed a traceback")
    if contents(folder) != before:
        found.append("changed something outside the run")
    return found


def check(cases, template, tmp_path, monkeypatch, capsys):
    """Run cases, each a file, an attack and a command; fail with the problems of all cases."""
    found = {}
    for number, (file, attack, command) in enumerate(cases):
        folder = tmp_path / str(number)
        attacked(template, folder, file, attack)
        wrong = problems(monkeypatch, capsys, folder, COMMANDS[command])
        if wrong:
            found[file, attack, command] = wrong
        monkeypatch.chdir(tmp_path)
        shutil.rmtree(folder)
    assert found == {}


def test_a_sample_of_attacks(template, puppets, tmp_path, monkeypatch, capsys):
    chosen = [case for case in CASES if case[1] != "newlines"][::12]
    cases = [(*case, command) for case, command in zip(chosen, cycle(COMMANDS))]
    check(cases, template, tmp_path, monkeypatch, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_works_before_an_attack(command, template, puppets, tmp_path, monkeypatch):
    shutil.copytree(template, tmp_path / "run")
    monkeypatch.chdir(tmp_path / "run")
    assert call(monkeypatch, *COMMANDS[command]) == 0


@pytest.mark.slow
@pytest.mark.parametrize("file", FILES)
def test_all_attacks(file, template, puppets, tmp_path, monkeypatch, capsys):
    attacks = [attack for attacked, attack in CASES if attacked == file]
    cases = [
        (file, attack, command)
        for number, attack in enumerate(attacks)
        for at, command in enumerate(COMMANDS)
        if number == 0 or (number + at) % 12 == 0
    ]
    check(cases, template, tmp_path, monkeypatch, capsys)
