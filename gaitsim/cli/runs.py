"""`gaitsim runs`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gaitsim.cli.run import Json


def runs(
    root: Annotated[Path, typer.Argument(help="Folder that holds the runs.")] = Path("runs"),
    delete: Annotated[
        list[str] | None,
        typer.Option(metavar="RUN", help="Delete a run with all its files; may be repeated."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Delete without asking.")] = False,
    json: Json = False,
) -> None:
    """List the runs in a folder, oldest first; or delete runs.

    [bold]Examples[/bold]

    gaitsim runs

    gaitsim runs experiments/spring --json

    gaitsim runs --delete spider-2 --delete spider-3
    """
    from gaitsim.cli.console import output, print_json, table
    from gaitsim.runs.folder import list_runs

    if delete:
        _delete(root, delete, yes=yes, json=json)
        return
    found = [_row(path) for path in list_runs(root)]
    if json:
        for row in found:
            print_json(row)
    elif not found:
        output().print(f"No runs in {root}. Begin one: gaitsim run spider", markup=False)
    else:
        made = table(
            "run", "body", "fitness", "generation", "best", "state", numbers=("generation", "best")
        )
        for row in found:
            made.add_row(*(str(row[key]) for key in ("run", "organism", "fitness")), *_cells(row))
        output().print(made, markup=False)


def _delete(root: Path, references: list[str], *, yes: bool, json: bool) -> None:
    """Delete runs, all of which must be there; asks first."""
    import sys

    from gaitsim.cli.console import notice, print_json, visible
    from gaitsim.errors import GaitsimError
    from gaitsim.runs.folder import EXPERIMENT, find_run
    from gaitsim.runs.removal import delete_run

    paths = [
        root / name if (root / name / EXPERIMENT).is_file() else find_run(name)
        for name in references
    ]
    named = visible(", ".join(map(str, dict.fromkeys(paths))))
    if not yes:
        if not sys.stdin.isatty():
            raise GaitsimError(
                f"{named} would be deleted, and no one can be asked",
                remedy="add --yes to delete without asking",
            )
        if not typer.confirm(f"Delete {named}, with all that was made of it?"):
            notice("Nothing was deleted.")
            return
    for path in dict.fromkeys(paths):
        delete_run(path)
        if json:
            print_json({"deleted": str(path)})
        else:
            print(visible(f"{path} is deleted"))


def _cells(row: dict[str, Any]) -> list[str]:
    done = f"{row['generation']}/{row['generations']}"
    best = "" if row["best"] is None else f"{row['best']:.4f}".replace("-", "−")
    return [done, best, row["state"]]


def _row(path: Path) -> dict[str, Any]:
    """A run's line; read without loading its plugins, so that a missing one does no harm."""
    from gaitsim.errors import GaitsimError
    from gaitsim.experiment import Evolution
    from gaitsim.runs.lock import is_locked
    from gaitsim.runs.opening import is_finished
    from gaitsim.runs.reader import Run
    from gaitsim.toml import parse

    row: dict[str, Any] = {
        "run": path.name,
        "organism": "",
        "fitness": "",
        "generation": 0,
        "generations": 0,
        "best": None,
        "state": "damaged",
    }
    run = Run(path)
    try:
        text = parse(run.experiment_text, str(path))
        for kind in ("organism", "fitness"):
            row[kind] = str(text[kind]["plugin"])
        evolution = Evolution.model_validate(text["evolution"])
        row["generations"] = evolution.generations
        found = run.checkpoint()
    # Pydantic's errors are ValueErrors.
    except (GaitsimError, KeyError, TypeError, ValueError):
        return row
    finished = False
    if found is not None:
        row["generation"] = found[0].generation
        row["best"] = found[0].best_score
        finished = is_finished(evolution, found[0], run.experiment_text)
    row["state"] = "running" if is_locked(path) else "finished" if finished else "stopped"
    return row
