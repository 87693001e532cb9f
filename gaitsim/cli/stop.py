"""`gaitsim stop`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.completion import run_names
from gaitsim.cli.options import Json
from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import echo, notice, print_json, status
from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.files.folder import command


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
    paths = _in_folders(runs or []) if all_ else [_find_evolving(name) for name in runs or []]
    for path in paths:
        request_stop(path)
    failures = [failure for path in paths if (failure := _wait(path, json)) is not None]
    if not paths and not json:
        echo("No run is evolving in the background.")
    if failures:
        raise failures[0]


def _in_folders(folders: list[str]) -> list[Path]:
    """Return the background runs, limited to `folders` if there are any."""
    from gaitsim.runs.background import background_processes, create_runtime_folder

    for folder in folders:
        if not Path(folder).is_dir():
            raise GaitsimError(
                f"folder not found: {folder}", allowed="with --all, folders that hold runs"
            )
    create_runtime_folder()  # raises an error if it cannot be used; otherwise no run would be found
    roots = [Path(folder).resolve() for folder in folders]
    found = [process.run for process in background_processes()]
    return [_relative(run) for run in found if not roots or run.parent in roots]


def _relative(run: Path) -> Path:
    """Return a path relative to the current folder, if it is inside."""
    here = Path.cwd()
    return run.relative_to(here) if run.is_relative_to(here) else run


def _find_evolving(name: str) -> Path:
    """Return the folder of a background run."""
    from gaitsim.cli.evolving import find_run_folder, not_evolving
    from gaitsim.live.process import background_state
    from gaitsim.runs.files.lock import RunLock

    path = find_run_folder(name)
    if background_state(path) is None:
        RunLock(path).release()  # raises an error that names the process evolving it elsewhere
        raise not_evolving(path)
    return path


def _wait(path: Path, json: bool) -> GaitsimError | None:
    """Wait until a run has stopped, and report it; return its failure if it failed."""
    from gaitsim.live.process import background_state
    from gaitsim.live.process import stop as stop_run
    from gaitsim.runs.background import last_failure
    from gaitsim.runs.resume import stop_reason_of
    from gaitsim.runs.snapshot import RunSnapshot

    try:
        with status(f"Stopping {path} after its current generation …"):
            if background_state(path) is not None:
                stop_run(path)
    except KeyboardInterrupt:
        notice(f"{path} will stop after its current generation.")
        sys.exit(INTERRUPTED)
    except RunError:
        pass  # the run has just ended
    failure = last_failure(path)
    if failure is not None:
        return failure
    run = RunSnapshot(path)
    reason = stop_reason_of(run)
    if json:
        state = "finished" if reason else "stopped"
        print_json({"run": str(path), "state": state, "generation": run.generation})
    elif reason:
        echo(f"{path}: {reason}")
    else:
        again = command("resume", path, "--detach")
        echo(f"{path}: stopped and saved at generation {run.generation}. Continue with: {again}")
    return None
