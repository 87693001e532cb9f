"""The commands in the documentation work as printed, page by page, after the presets' own runs."""

import re
import shlex
import shutil
from collections.abc import Callable
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
import typer

from gaitsim.cli.app import app
from gaitsim.cli.help import LazyGroup

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").glob("*.md"))]
HELP = sorted((ROOT / "gaitsim" / "cli").rglob("*.py"))

NOT_RUN = re.compile(
    r"gaitsim (tui|serve|play|study|compare|gallery|plugins|imitate|attach|stop|steer(?! --out))"
    r"|run (walker|millipede)|--interactive|--dask|--detach|night|--delete|--perturb|champions/"
    r"|hopper|my-|mine|spring|--root"
)
"""Commands that do not end by themselves, take long, or need a file of the reader's."""

EXTRAS = {"--engine bullet": "pybullet", "--format tensorboard": "tensorboardX"}
"""Modules that some options need."""


def commands(text: str) -> list[str]:
    """The commands in a page's blocks and a module's examples, in order."""
    blocks = re.findall(r"^```(?:sh|console)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    lines = re.findall(r"^(?:\$ | *)(gaitsim .*)", "".join(blocks), re.MULTILINE)
    examples = re.findall(r"^    (gaitsim .*)", text.partition("[bold]Example")[2], re.MULTILINE)
    return [line for line in (*lines, *examples) if "…" not in line]


def in_rows(text: str) -> list[str]:
    """The commands in the first column of a page's tables."""
    rows = re.findall(r"^\| (.*?) \|", text, re.MULTILINE)
    return [code for row in rows for code in re.findall(r"`(gaitsim [^`]*)`", row)]


def words(command: str) -> list[str]:
    """What a shell passes to the program."""
    found = shlex.split(re.split(r" [|>#] ", command)[0])
    return found[1:]


QUADRUPED = ROOT / "plugins" / "gaitsim_robot" / "models" / "quadruped.xml"
FOUND = {path: commands(path.read_text()) for path in (*PAGES, *HELP)}
FOUND[README] += in_rows(README.read_text())
FOUND = {path: lines for path, lines in FOUND.items() if lines}


def test_commands_are_found() -> None:
    text = "```sh\ngaitsim b 'c d'  # e\n  gaitsim f > g\n```\n[bold]Examples\n\n    gaitsim h\n"
    assert [words(line) for line in commands(text)] == [["b", "c d"], ["f"], ["h"]]
    assert in_rows("| `gaitsim a`, `gaitsim b` | `gaitsim c` |\n") == ["gaitsim a", "gaitsim b"]
    assert all(sum(len(FOUND.get(path, ())) for path in paths) > 40 for paths in (PAGES, HELP))


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.name)
def test_the_commands_of_a_page_parse(path: Path) -> None:
    for line in FOUND[path]:
        command, rest = typer.main.get_command(app), words(line)
        while isinstance(command, LazyGroup) and rest:
            command, rest = command.load(rest[0]), rest[1:]
        command.make_context("gaitsim", rest)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Runs of presets as long as they are by default, with few individuals."""
    import gaitsim as gs

    folder = tmp_path_factory.mktemp("docs") / "runs"
    for preset, population, generations in (
        ("spider", 4, None),
        ("fly", 8, None),
        ("spider-front", 8, None),
        ("spider-atlas", 20, 300),
        ("quadruped", 4, 2),
        ("walker", 4, 2),
    ):
        options = {"population": population, "generations": generations}
        for _ in gs.evolve(preset, **options, out=folder / preset):
            pass
    shutil.copytree(folder / "spider", folder / "spider-2")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.name)
def test_the_commands_of_a_page_run(
    path: Path, runs: Path, tmp_path: Path, gaitsim: Callable[..., object]
) -> None:
    shutil.copytree(runs, tmp_path / "runs")
    shutil.copy(QUADRUPED, tmp_path / "my_robot.urdf")  # the root element tells the format
    for line in FOUND[path]:
        installed = all(find_spec(needed) for flag, needed in EXTRAS.items() if flag in line)
        if installed and not NOT_RUN.search(line):
            gaitsim(*quick(words(line), tmp_path / "runs"))


def quick(arguments: list[str], runs: Path) -> list[str]:
    """The same command with less work."""
    command, *_ = arguments
    if command == "video":
        return [*arguments, "--size", "320x180", "--fps", "1", "--speed", "1"]
    if "--worlds" in arguments:
        return [
            "10" if before == "--worlds" else word for before, word in pairwise(["", *arguments])
        ]
    if command not in ("run", "atlas"):
        return arguments
    if "--generations" not in arguments:
        return [*arguments, "--population", "20", "--generations", "2"]
    name = arguments[1] + "-atlas" * (command == "atlas")
    shutil.rmtree(runs / name, ignore_errors=True)  # the page's run is this one
    return [*arguments, "--population", "20"]
