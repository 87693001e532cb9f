"""Runs in the background, from the command line: begin one, and find it again."""

import time
from pathlib import Path

from gaitsim.cli.console import echo, output, print_json
from gaitsim.cli.summary import summarise
from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.background import (
    check_detached,
    evolving,
    send,
    start_detached,
)
from gaitsim.live.places import places
from gaitsim.live.protocol import Command
from gaitsim.runs.background import DOES, background_process, last_failure, make_runtime_folder
from gaitsim.runs.files.folder import RUNS, command, find_run
from gaitsim.runs.resume import stop_reason_of
from gaitsim.runs.snapshot import RunSnapshot

FIRST_MOMENTS = 1.0  # seconds in which a process that fails is reported by the one that began it
PERIOD = 0.05


def check_detachable(dask: str | None) -> None:
    """Check that runs can evolve in the background, before a folder is created.

    Raises:
        GaitsimError: they cannot, or not on a cluster, which the command line begins and ends.
    """
    make_runtime_folder()
    places()
    if dask is not None:
        raise GaitsimError(
            "--dask cannot be combined with --detach",
            remedy="leave out --detach, and start gaitsim in a terminal multiplexer such as tmux",
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
    """Evolve the run in `path` in the background; say how to watch and to stop it.

    A run that is paused there continues.

    Raises:
        GaitsimError: it cannot be evolved, as far as that is known at once or soon.
    """
    if evolving(path) == "paused" and not overrides and generations is None:
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
    while (state := evolving(path)) == "preparing" and time.monotonic() < end:
        time.sleep(PERIOD)
    if state is not None:
        _report(path, state, json)
        return
    reason = "" if last_failure(path) else stop_reason_of(RunSnapshot(path))
    if not reason:
        raise at_rest(path)
    summarise(path, reason, json)


def _report(path: Path, state: str, json: bool) -> None:
    process = background_process(path)
    pid = process.pid if process else None
    if json:
        print_json({"run": str(path), "state": state, "process": pid})
        return
    later = " It evolves when one of the runs before it ends." if state == "queued" else ""
    echo(f"{path} {DOES[state]} in the background, in process {pid}.{later}")
    for verb, purpose in (("attach", "watch it"), ("stop", "stop and save it")):
        output().print(f"  {command(verb, path)}  ", end="", soft_wrap=True)
        output().print(f"# {purpose}", style="dim")


def at_rest(path: Path) -> GaitsimError:
    """Return the error of a run that does not evolve now: why it failed, where it did."""
    return last_failure(path) or RunError(
        f"the run {path} does not evolve now",
        remedy=f"see it: {command('show', path)}; or continue it: "
        f"{command('resume', path, '--detach')}",
    )


def find_evolved(reference: str) -> Path:
    """Return the folder of a run; of one that evolves in the background even if it is deleted.

    Raises:
        RunError: there is no such run, or its folder was deleted while it was evolved.
    """
    places = [Path(place) for place in (reference, RUNS / reference) if reference]
    for path in places:
        if evolving(path):
            return path
    try:
        return find_run(reference)
    except RunError:
        failures = [failure for path in places if (failure := last_failure(path))]
        if failures:
            raise failures[0] from None
        raise
