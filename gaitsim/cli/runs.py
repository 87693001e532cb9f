"""`gaitsim runs`."""

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitsim.cli.completion import run_names
from gaitsim.cli.options import Json
from gaitsim.console.printing import confirm, echo, notice, output, print_json, print_table
from gaitsim.errors import GaitsimError
from gaitsim.registry.entry_points import PYTHON, is_outside
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.folder import RUNS, command, find_run, holds_run
from gaitsim.runs.manage import delete_run
from gaitsim.runs.overview import Overview, list_overviews


def runs(
    root: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder that holds the runs.")
    ] = Path("runs"),
    delete: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RUN",
            help="Delete a run with all its files; may be repeated.",
            autocompletion=run_names,
        ),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Delete without asking.")] = False,
    json: Json = False,
) -> None:
    """List the runs in a folder, oldest first, or delete some of them.

    [bold]Examples[/bold]

    gaitsim runs

    gaitsim runs experiments/spring --json

    gaitsim runs --delete spider-2 --delete spider-3
    """
    check_root(root)
    if delete:
        _delete(root, delete, yes=yes, json=json)
        return
    found = [_row(run) for run in list_overviews(root, _read_in_full)]
    if json:
        for row in found:
            print_json(row)
    elif not found:
        output().print(f"No runs in {root}. Start one: gaitsim run spider")
    else:
        rows = []
        for row in found:
            best = "" if row["best"] is None else number(row["best"], 4)
            done = f"{row['generation']}/{row['generations']}"
            rows.append([row["run"], row["organism"], row["fitness"], done, best, row["state"]])
        columns = "run", "body", "fitness", "generation", "best", "state"
        print_table(columns, rows, numbers=["generation", "best"])
        if any(row["outside"] for row in found):
            output().print(
                f"{PYTHON} is Python code outside the run, so the run cannot be reproduced from "
                "its files alone"
            )
        for row in found:
            if row["failure"]:
                notice(f"{root / row['run']} failed: {row['failure']}")


def check_root(root: Path) -> None:
    """Check that a folder can hold runs; only `runs` may be missing, before the first run."""
    if holds_run(root):
        raise GaitsimError(
            f"{root} is a run",
            allowed="a folder that holds runs",
            remedy=command("show", root),
        )
    # Unlike pathlib, os.path accepts names that are invalid for files.
    if root != RUNS and not os.path.exists(root):  # noqa: PTH110
        raise GaitsimError(
            f"folder not found: {root}",
            allowed="a folder that holds runs",
            remedy="'gaitsim runs' lists the runs in runs/",
        )


def _delete(root: Path, references: list[str], *, yes: bool, json: bool) -> None:
    """Delete runs after confirmation; all of them must exist."""
    paths = [root / name if holds_run(root / name) else find_run(name) for name in references]
    named = ", ".join(map(str, dict.fromkeys(paths)))
    if not yes:
        if not sys.stdin.isatty():
            raise GaitsimError(
                f"{named} cannot be deleted: there is no terminal to confirm it",
                remedy="add --yes to delete without asking",
            )
        if not confirm(f"Delete {named}, including all exports?"):
            notice("Nothing was deleted.")
            return
    for path in dict.fromkeys(paths):
        delete_run(path)
        if json:
            print_json({"deleted": str(path)})
        else:
            echo(f"{path}: deleted")


def _read_in_full(path: Path) -> Overview | None:
    from gaitsim.runs.growing import overview

    return overview(path)


def _row(run: Overview) -> dict[str, Any]:
    """Return the row of a run, without loading plugins, which may be missing."""
    return {
        "run": run.name,
        "organism": run.plugins.get("organism", ""),
        "fitness": run.plugins.get("fitness", ""),
        "generation": run.generation,
        "generations": run.generations,
        "best": run.best,
        "state": run.state,
        "failure": run.failure.what if run.failure else None,
        "outside": [name for name in run.plugins.values() if is_outside(name)],
    }
