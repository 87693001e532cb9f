"""`gaitsim stop`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitsim.cli.completion import run_names
from gaitsim.cli.options import Json
from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import echo, notice, print_json, status
from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.files.folder import command

if TYPE_CHECKING:
    from gaitsim.runs.snapshot import RunSnapshot


def stop(
    runs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="RUN",
            help="Runs to stop; with --all, folders that hold runs.",
            autocompletion=run_names,
        ),
    ] = None,
    all_: Annotated[
        bool, typer.Option("--all", help="Stop all background runs, or all in the given folders.")
    ] = False,
    json: Json = False,
) -> None:
    """Stop background runs after their current generation, and save them.

    [bold]Examples[/bold]

    gaitsim run spider --detach --out runs/night

    gaitsim stop night

    gaitsim stop --all

    gaitsim stop --all runs
    """
    from gaitsim.live.process import request_stop

    if not runs and not all_:
        raise GaitsimError(
            "no run is given",
            remedy="name a run ('gaitsim runs' lists them), or stop all background runs with --all",
        )
    found = _in_folders(runs or []) if all_ else [_find_evolving(name) for name in runs or []]
    for run in found:
        request_stop(run.path)
    failures = [failure for run in found if (failure := _wait(run, json)) is not None]
    if not found and not json:
        echo("No run is evolving in the background.")
    if failures:
        raise failures[0]


def _in_folders(folders: list[str]) -> list[RunSnapshot]:
    """Return the background runs, limited to `folders` if there are any."""
    from gaitsim.runs.background import background_processes, create_runtime_folder
    from gaitsim.runs.snapshot import RunSnapshot

    for folder in folders:
        if not Path(folder).is_dir():
            raise GaitsimError(
                f"folder not found: {folder}", allowed="with --all, folders that hold runs"
            )
    create_runtime_folder()  # raises an error if it cannot be used; otherwise no run would be found
    roots = [Path(folder).resolve() for folder in folders]
    found = [process.run for process in background_processes()]
    return [RunSnapshot(_relative(run)) for run in found if not roots or run.parent in roots]


def _relative(run: Path) -> Path:
    """Return a path relative to the current folder, if it is inside."""
    here = Path.cwd()
    return run.relative_to(here) if run.is_relative_to(here) else run


def _find_evolving(name: str) -> RunSnapshot:
    """Return a background run."""
    from gaitsim.cli.evolving import find_evolving, not_evolving
    from gaitsim.runs.lock import RunLock

    run = find_evolving(name)
    if run.process is None:
        RunLock(run.path).release()  # raises an error that names the process evolving it elsewhere
        raise not_evolving(run)
    return run


def _wait(run: RunSnapshot, json: bool) -> GaitsimError | None:
    """Wait until a run has stopped, and report it; return its failure if it failed."""
    from gaitsim.live.process import stop as stop_run

    path = run.path
    try:
        with status(f"Stopping {path} after its current generation …"):
            if run.process is not None:
                stop_run(path)
    except KeyboardInterrupt:
        notice(f"{path} will stop after its current generation.")
        sys.exit(INTERRUPTED)
    except RunError:
        pass  # the run has just ended
    run = run.reopened()
    if run.failure is not None:
        return run.failure
    reason = run.stop_reason
    if json:
        state = "finished" if reason else "stopped"
        print_json({"run": str(path), "state": state, "generation": run.generation})
    elif reason:
        echo(f"{path}: {reason}")
    else:
        again = command("resume", path, "--detach")
        echo(f"{path}: stopped and saved at generation {run.generation}. Continue with: {again}")
    return None
