"""The processor time of each command, compared with an empty Typer command with one option."""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

from timing import milliseconds, print_budget, print_figure, print_machine, times
from typer.main import get_command

from gaitsim.cli.app import app
from gaitsim.evaluation import evaluate
from gaitsim.experiment import load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter

ROUNDS = 10
MANY = 200  # runs
EMPTY = """\
import typer
app = typer.Typer()
@app.command()
def empty(option: str = "") -> None:
    pass
app()
"""
START, LIST, SHOW = 1.5, 2.5, 2.0  # budgets, times the empty command
COMPLETED = {"show wa": "show RUN", "run sp": "run NAME"}  # command lines that a shell completes


def processor_time(command: list[str], folder: Path, environment: dict[str, str]) -> float:
    """Run a program, which must exit with code 0; return its processor time, seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        command, cwd=folder, env={**os.environ, **environment}, check=True, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def command_lines() -> list[tuple[str, ...]]:
    """Return the words of each command, without groups."""
    found = []
    for name in get_command(app).places:
        inner = getattr(get_command(app).load(name), "places", None)
        found += [(name, one) for one in inner] if inner else [(name,)]
    return found


def create_runs(folder: Path) -> None:
    """Create the folders `one` and `many` with 1 and 200 short runs of the walker."""
    experiment = load_experiment("walker", {"evolution.generations": 20})
    path = create_run(experiment, folder / "one/runs/walker")
    with RunWriter.open(path) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass
    for number in range(MANY):
        shutil.copytree(path, folder / f"many/runs/walker-{number}")


def main() -> None:
    """Print the figures."""
    print_machine()
    python = sys.executable
    gaitsim = str(Path(python).with_name("gaitsim"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        create_runs(folder)
        (folder / "empty.py").write_text(EMPTY)
        empty = [python, str(folder / "empty.py")]
        one, many = folder / "one", folder / "many"
        # Label, command, folder, environment, and budget in times the empty command.
        works: list[tuple[str, list[str], Path, dict[str, str], float | None]] = [
            ("empty command", empty, one, {}, None),
            ("empty command --help", [*empty, "--help"], one, {}, None),
            ("gaitsim --help", [gaitsim, "--help"], one, {}, START),
        ]
        for words in command_lines():
            line = [gaitsim, *words, "--help"]
            works.append((" ".join(["gaitsim", *words, "--help"]), line, one, {}, START))
        for typed, label in COMPLETED.items():
            asked = {
                "_GAITSIM_COMPLETE": "complete_bash",
                "COMP_WORDS": f"gaitsim {typed}",
                "COMP_CWORD": str(len(typed.split())),
            }
            works.append((f"completion of gaitsim {label}", [gaitsim], one, asked, START))
        works += [
            ("gaitsim runs, 1 run", [gaitsim, "runs"], one, {}, START),
            (f"gaitsim runs, {MANY} runs", [gaitsim, "runs"], many, {}, LIST),
            (
                "gaitsim show, with the champion's measures",
                [gaitsim, "show", "walker"],
                one,
                {},
                SHOW,
            ),
        ]
        least = [float("inf")] * len(works)
        for _ in range(ROUNDS + 1):  # in turns; the first round fills caches
            for at, (_, command, where, environment, _) in enumerate(works):
                least[at] = min(least[at], processor_time(command, where, environment))
    print("minimum processor time, and times the empty command\n")
    for (label, _, _, _, budget), seconds in zip(works, least, strict=True):
        what = f"{label}, {milliseconds(seconds)}"
        ratio = seconds / (least[1] if label.endswith("--help") else least[0])
        if budget is None:
            print_figure(what, times(ratio))
        else:
            print_budget(what, ratio, budget, times)


if __name__ == "__main__":
    main()
