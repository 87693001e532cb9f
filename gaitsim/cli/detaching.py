"""Background runs on the command line: start them, and find them."""

import time
from pathlib import Path

from gaitsim.cli.summary import summarise
from gaitsim.console.printing import echo, output, print_json
from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.background import (
    background_state,
    check_detached,
    send,
    start_detached,
)
from gaitsim.live.protocol import Command
from gaitsim.live.slots import slot_count
from gaitsim.runs.background import (
    STATE_PREDICATES,
    background_process,
    create_runtime_folder,
    last_failure,
)
from gaitsim.runs.files.folder import RUNS, command, find_run
from gaitsim.runs.resume import stop_reason_of
from gaitsim.runs.snapshot import RunSnapshot

FIRST_MOMENTS = 1.0  # seconds for which the command waits for an early failure
PERIOD = 0.05  # seconds between checks


def check_detachable(dask: str | None) -> None:
    """Check, before a folder is created, that a run can evolve in the background."""
    create_runtime_folder()
    slot_count()
    if dask is not None:
        raise GaitsimError(
            "--dask cannot be combined with --detach",
            remedy="omit --detach, and start gaitsim in a terminal multiplexer such as tmux",
        )


def evolve_detached(
    path: Path,
    *,
    workers: int | None,
    json: bool,
    overrides: Overrides | None = None,
    generations: int | None = None,
    any_version: bool = False,
) -> None:
    """Evolve the run in `path` in the background; print how to watch and stop it.

    A run that is paused in the background continues.
    """
    if background_state(path) == "paused" and not overrides and generations is None:
        send(path, Command("go"))
        _report(path, "running", json)
        return
    check_detached(path, overrides, generations, any_version=any_version)
    start_detached(
        path,
        generations=generations,
        workers=workers,
        overrides=overrides,
        any_version=any_version,
    )
    end = time.monotonic() + FIRST_MOMENTS
    while (state := background_state(path)) == "preparing" and time.monotonic() < end:
        time.sleep(PERIOD)
    if state is not None:
        _report(path, state, json)
        return
    reason = "" if last_failure(path) else stop_reason_of(RunSnapshot(path))
    if not reason:
        raise not_evolving(path)
    summarise(path, reason, json)


def _report(path: Path, state: str, json: bool) -> None:
    process = background_process(path)
    pid = process.pid if process else None
    if json:
        print_json({"run": str(path), "state": state, "process": pid})
        return
    later = " It starts when an earlier run ends." if state == "queued" else ""
    echo(f"{path} {STATE_PREDICATES[state]} in the background, in process {pid}.{later}")
    for verb, purpose in (("attach", "watch it"), ("stop", "stop and save it")):
        output().print(f"  {command(verb, path)}  ", end="", soft_wrap=True)
        output().print(f"# {purpose}", style="dim")


def not_evolving(path: Path) -> GaitsimError:
    """Return the error for a run that is not evolving: the run's own failure, if it failed."""
    return last_failure(path) or RunError(
        f"the run {path} is not evolving",
        remedy=f"show it: {command('show', path)}; or continue it: "
        f"{command('resume', path, '--detach')}",
    )


def find_run_folder(reference: str) -> Path:
    """Return the folder of a run; for a background run, even if its folder was deleted."""
    places = [Path(place) for place in (reference, RUNS / reference) if reference]
    for path in places:
        if background_state(path):
            return path
    try:
        return find_run(reference)
    except RunError:
        failures = [failure for path in places if (failure := last_failure(path))]
        if failures:
            raise failures[0] from None
        raise
