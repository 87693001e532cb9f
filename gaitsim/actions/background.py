"""`gaitsim attach` and `gaitsim stop`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.actions.action import JSON, Action, OneRun, argument
from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import echo, notice, print_json, status
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError, RunError
from gaitsim.storage.files.folder import command

if TYPE_CHECKING:
    from gaitsim.storage.snapshot import RunSnapshot


class Attach(OneRun):
    """Watch a run that is evolving in the background or in another program.

    Ctrl-C stops watching; the run continues.

    [bold]Examples[/bold]

    gaitsim run spider-genetic --detach --out runs/night

    gaitsim attach night

    gaitsim attach night --json > log.jsonl
    """

    def do(self) -> None:
        """Show the run until it ends, and print how it ended."""
        import asyncio

        from gaitsim.console.evolving import find_evolving, follow_run, not_evolving
        from gaitsim.console.run_end import summarise
        from gaitsim.storage.lock import is_locked

        found = find_evolving(self.run)
        path, in_background = found.path, found.process is not None
        if not in_background and not is_locked(path):
            raise not_evolving(found)
        last = asyncio.run(follow_run(path, self.json_lines, in_background=in_background))
        match last.state:
            case "finished":
                summarise(found.reopened(), last.reason, self.json_lines)
            case "stopped":
                notice(f"Stopped and saved. Continue with: {command('resume', path)}")
                sys.exit(INTERRUPTED)
            case "failed" if last.error is not None:
                raise last.error
            case _:
                stop = f" Stop it: {command('stop', path)}." if in_background else ""
                notice(f"{path} is still evolving.{stop} Watch it again: {command('attach', path)}")
                sys.exit(INTERRUPTED)


class Stop(Action):
    """Stop background runs after their current generation, and save them.

    [bold]Examples[/bold]

    gaitsim run spider-genetic --detach --out runs/night

    gaitsim stop night

    gaitsim stop --all

    gaitsim stop --all runs
    """

    runs: Names | None = argument("runs to stop; with --all, folders that hold runs", "RUN", None)
    all_: bool = option(
        False, "stop all background runs, or all in the given folders", flag="--all"
    )
    json_lines: bool = JSON

    def do(self) -> None:
        """Ask all runs to stop, and wait for each."""
        from gaitsim.live.process import request_stop

        names = self.runs or ()
        if not names and not self.all_:
            raise GaitsimError(
                "no run is given",
                remedy="name a run ('gaitsim runs' lists them), or stop all background runs with "
                "--all",
            )
        found = _in_folders(names) if self.all_ else [_find_evolving(name) for name in names]
        for run in found:
            request_stop(run.path)
        waited = [_wait(run, self.json_lines) for run in found]
        if not found and not self.json_lines:
            echo("No run is evolving in the background.")
        for failure in waited:
            if failure is not None:
                raise failure


def _in_folders(folders: tuple[str, ...]) -> list[RunSnapshot]:
    """Return the background runs, limited to `folders` if there are any."""
    from gaitsim.storage.background import background_processes, create_runtime_folder
    from gaitsim.storage.snapshot import RunSnapshot

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
    from gaitsim.console.evolving import find_evolving, not_evolving
    from gaitsim.storage.lock import RunLock

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
