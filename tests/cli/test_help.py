"""Help is quick, and readable at 80 columns."""

import os
import re
import subprocess
import sys
from functools import partial

import pytest
import typer

from gaitsim import cli
from gaitsim.cli.app import app
from gaitsim.evaluation import evaluate
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter

HEAVY = (
    *("numpy", "numba", "scipy", "matplotlib", "textual", "tomlkit", "PIL", "av", "pymunk"),
    *("mujoco", "filelock", "multiprocessing"),
)


def commands(command=None, path=()):
    """Return every command, by the words that call it."""
    command = command or typer.main.get_command(app)
    found = {path: command}
    for name in getattr(command, "places", {}):
        found.update(commands(command.load(name), (*path, name)))
    return found


COMMANDS = commands()


@pytest.fixture
def gaitsim(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "dumb")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["gaitsim", *arguments])
        with pytest.raises(SystemExit) as raised:
            cli.main()
        captured = capsys.readouterr()
        assert captured.err == ""
        assert not raised.value.code
        return captured.out

    return run


@pytest.mark.parametrize("command", COMMANDS)
def test_the_help_of_each_command_fits_80_columns(gaitsim, command):
    text = gaitsim(*command, "--help")
    assert text == gaitsim(*command, "-h")
    assert all(len(line) <= 80 for line in text.splitlines())
    assert not re.search(r"<\w+( range)?>|\{", text), "placeholders are words in upper case"
    assert "[bold]" not in text
    assert "Usage: gaitsim" in text


@pytest.mark.parametrize("path", [path for path in COMMANDS if path])
def test_the_line_in_a_list_begins_the_help_of_its_command(path):
    *group, name = path
    first, _, _ = COMMANDS[path].help.partition("\n\n")
    parent = COMMANDS[tuple(group)]
    parent.list_commands(None)
    assert parent.commands[name].help == " ".join(first.split())


@pytest.mark.parametrize(("typed", "meant"), [(("rnu",), "run"), (("plugins", "lst"), "list")])
def test_a_mistyped_command_is_corrected(monkeypatch, capsys, typed, meant):
    monkeypatch.setattr(sys, "argv", ["gaitsim", *typed])
    with pytest.raises(SystemExit, match="2"):
        cli.main()
    assert f"Did you mean '{meant}'?" in capsys.readouterr().err


def test_the_version_is_printed(gaitsim):
    from importlib.metadata import version

    assert gaitsim("--version") == f"gaitsim {version('gaitsim')}\n"


def imported(*arguments, path=(), environment=None, folder=None):
    """Return the top-level packages that a command imports, and its standard error."""
    code = (
        f"import sys; sys.path[:0] = {list(map(str, path))}; sys.argv = {['gaitsim', *arguments]}\n"
        "from gaitsim.cli import main\n"
        "try: main()\n"
        "finally: print(*{m.partition('.')[0] for m in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **(environment or {})},
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stderr.split())


def test_help_imports_neither_numpy_nor_pydantic_nor_anything_heavy():
    found = imported("--help")
    assert "typer" in found
    assert not found & {*HEAVY, "pydantic", "markdown_it", "pygments"}


def test_the_help_and_completion_of_a_command_import_nothing_heavy():
    """Commands declare their options without the modules that do their work."""
    code = (
        "import sys\n"
        "from typer.main import get_command\n"
        "from gaitsim.cli.app import app\n"
        f"for path in {[path for path in COMMANDS if path]}:\n"
        "    command, before = get_command(app), set(sys.modules)\n"
        "    for name in path: command = command.load(name)\n"
        "    new = {module.partition('.')[0] for module in {*sys.modules} - before}\n"
        f"    print(*path, *new.intersection({HEAVY}), sep=',')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [",".join(path) for path in COMMANDS if path]


@pytest.mark.parametrize("words", ["run sp", "show wa", "runs --delete wa", "plugins show sp"])
def test_completion_of_names_imports_nothing_heavy(tmp_path, words):
    (tmp_path / "runs/walk").mkdir(parents=True)
    (tmp_path / "runs/walk/experiment.toml").touch()
    environment = {
        "_GAITSIM_COMPLETE": "complete_bash",
        "COMP_WORDS": f"gaitsim {words}",
        "COMP_CWORD": str(len(words.split())),
    }
    found = imported(environment=environment, folder=tmp_path)
    assert "typer" in found
    assert not found & {*HEAVY}


def test_the_list_of_runs_imports_nothing_heavy_and_no_plugin(puppet, tmp_path):
    path = create_run(puppet(), tmp_path / "runs/walk")
    with RunWriter.open(path) as writer:
        next(writer.evolve(partial(evaluate, writer.experiment)))
    for arguments in (["runs"], ["runs", "--json"]):
        found = imported(*arguments, folder=tmp_path)
        assert "typer" in found
        assert not found & {*HEAVY}
        assert not [name for name in found if name.startswith("gaitsim_")]


@pytest.mark.parametrize("command", ["plugins list", "experiments list"])
def test_lists_import_no_plugin_and_nothing_heavy(install, command):
    folder = install(
        "fakes",
        files={
            "fakes/__init__.py": "raise SystemExit('imported')",
            "fakes/hop.toml": "description = 'hops'",
            "fakes-1.0.dist-info/entry_points.txt": "[gaitsim.experiments]\nhop = fakes\n"
            "[gaitsim.organism]\nhopper = fakes:Hopper\n",
        },
    )
    found = imported(*command.split(), path=[folder])
    assert "rich" in found
    assert not found & {*HEAVY, "fakes"}
    assert not [name for name in found if name.startswith("gaitsim_")]
