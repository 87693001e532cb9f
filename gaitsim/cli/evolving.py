"""Evolve a run from the command line, with progress, Ctrl-C and a final summary."""

import os
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal, NoReturn, Unpack

import numpy as np

from gaitsim.cli.cluster import cluster, warn
from gaitsim.cli.codes import challenge_as_start, read_challenge
from gaitsim.cli.display import Display
from gaitsim.cli.progress import display, row_of, snapshot_of
from gaitsim.cli.summary import summarise
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, output, print_json, status
from gaitsim.console.streams import results
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Executor
from gaitsim.experiment import Experiment, parse_assignments
from gaitsim.live.process import background_state, check_detached, send, start_detached
from gaitsim.live.protocol import Command
from gaitsim.live.slots import slot_count
from gaitsim.registry.entry_points import interrupted_plugin
from gaitsim.runs.background import (
    STATE_PREDICATES,
    create_runtime_folder,
    last_failure,
)
from gaitsim.runs.compatibility import check_start
from gaitsim.runs.creation import find_individual
from gaitsim.runs.files.checkpoint import Champion
from gaitsim.runs.files.folder import RUNS, command, find_run
from gaitsim.runs.files.history import row
from gaitsim.runs.resume import ResumeOptions
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.writer import RunWriter
from gaitsim.sharing.challenge import Challenge

SLOW = 1.0  # seconds; shorter preparations are not reported
FIRST_MOMENTS = 1.0  # seconds for which the command waits for an early failure in the background
PERIOD = 0.05  # seconds between checks

Place = Executor | Literal["background"] | None
"""Where a run evolves: on a cluster, in the background, or in this process."""


def command_line_options(
    generations: int | None, population: int | None, seed: int | None, set_: Sequence[str] | None
) -> dict[str, Any]:
    """Return the experiment options given on the command line, by key."""
    short = {
        "evolution.generations": generations,
        "evolution.population": population,
        "seed": seed,
    }
    given = {key: value for key, value in short.items() if value is not None}
    return {**given, **parse_assignments(set_ or ())}


def starting_individual(experiment: Experiment, from_: str | Challenge | None) -> Champion | None:
    """Return the individual that `--from` names, or that of a challenge code already read."""
    if from_ is None:
        return None
    challenge = read_challenge(from_) if isinstance(from_, str) else from_
    start = find_individual(str(from_)) if challenge is None else challenge_as_start(challenge)
    check_start(experiment, start, f"--from {'CODE' if challenge else from_}")
    return start


@contextmanager
def chosen_place(dask: str | None, workers: int | None, *, detach: bool) -> Iterator[Place]:
    """Check, before a folder is created, that a run can evolve in the chosen place; yield it."""
    if not detach:
        with cluster(dask, workers) as executor:
            yield executor
        return
    create_runtime_folder()
    slot_count()
    if dask is not None:
        raise GaitsimError(
            "--dask cannot be combined with --detach",
            remedy="omit --detach, and start gaitsim in a terminal multiplexer such as tmux",
        )
    yield "background"


def evolve_run(
    run: RunSnapshot,
    place: Place,
    *,
    workers: int | None,
    json: bool,
    **options: Unpack[ResumeOptions],
) -> None:
    """Evolve a run from its last generation, and print a summary.

    Exits with code 130 if the user stops the run.
    """
    if place == "background":
        _evolve_in_background(run, workers, json, **options)
        return
    with interruptible() as interrupts:
        try:
            with RunWriter.open(
                run.path, workers=workers, cluster=place, on_warning=warn, **options
            ) as writer:
                shown, reason = _prepare(writer, json), writer.done
                if not reason:
                    with interrupts.deferring(shown.stopping), shown:
                        for generation in writer.evolve():
                            snapshot = snapshot_of(generation, writer.experiment)
                            shown.update(snapshot, [row_of(generation, snapshot)])
                            reason = generation.stop
                            if reason or interrupts.requested:
                                break
        except KeyboardInterrupt:
            _exit_immediately(run)
    if interrupts.requested and not reason:
        notice(f"Stopped and saved. Continue with: {command('resume', run.path)}")
        sys.exit(INTERRUPTED)
    summarise(run.reopened(), reason, json, workers)


def _prepare(writer: RunWriter, json: bool) -> Display:
    """Return the display of a run; prepare its first generation, unless a stop condition holds."""
    if writer.warning:
        warn(writer.warning)
    experiment, last = writer.experiment, writer.last
    rows, first = (writer.run.history, writer.run.first_comparable) if last else ({}, 1)
    shown = display(writer.path, snapshot_of(last, experiment, rows=rows, scored_from=first), json)
    if writer.done:
        return shown
    name = experiment.entries["organism"].name
    start = time.perf_counter()
    with status(f"Preparing {name}: the first run compiles its kernels …"):
        writer.prepare()
    seconds = time.perf_counter() - start
    if seconds > SLOW:
        notice(f"Prepared {name} in {seconds:.1f} s.")
    if writer.reevaluates and last is not None:
        with status(f"Re-evaluating the population of generation {last.number} …"):
            writer.reevaluate()
    if writer.changes:
        reevaluated = None
        if writer.last is not None and any(change.reevaluates for change in writer.changes):
            rows = {name: np.array([value]) for name, value in row(writer.last).items()}
            reevaluated = snapshot_of(writer.last, experiment, rows=rows)
        first_changed = last.number + 1 if last else 1
        shown.start_stage(writer.stage, first_changed, [*map(str, writer.changes)], reevaluated)
    return shown


def _exit_immediately(run: RunSnapshot) -> NoReturn:
    """Exit immediately; the run folder is complete at any time."""
    working = interrupted_plugin()
    if working:
        notice(f"When the run was stopped, {working}.")
    notice(f"Stopped at the last saved generation. Continue with: {command('resume', run.path)}")
    if all(thread.daemon or thread is threading.main_thread() for thread in threading.enumerate()):
        sys.exit(INTERRUPTED)
    # A normal exit would wait for threads, which compiled code may keep busy.
    for stream in (results(), sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(INTERRUPTED)


def _evolve_in_background(
    run: RunSnapshot, workers: int | None, json: bool, **options: Unpack[ResumeOptions]
) -> None:
    """Evolve a run in the background, or continue it if paused; print how to watch and stop it."""
    path, process = run.path, run.process
    changed = options.get("overrides") or options.get("generations") is not None
    if process is not None and process.state == "paused" and not changed:
        send(path, Command("go"))
        state: str | None = "running"
    else:
        check_detached(path, **options)
        start_detached(path, workers=workers, **options)
        end = time.monotonic() + FIRST_MOMENTS
        while (state := background_state(path)) == "preparing" and time.monotonic() < end:
            time.sleep(PERIOD)
    if state is None:
        run = run.reopened()
        reason = "" if run.failure else run.stop_reason
        if not reason:
            raise not_evolving(run)
        summarise(run, reason, json)
        return
    process = run.process
    pid = process.pid if process else None
    if json:
        print_json({"run": str(path), "state": state, "process": pid})
        return
    later = " It starts when an earlier run ends." if state == "queued" else ""
    echo(f"{path} {STATE_PREDICATES[state]} in the background, in process {pid}.{later}")
    for verb, purpose in (("attach", "watch it"), ("stop", "stop and save it")):
        output().print(f"  {command(verb, path)}  ", end="", soft_wrap=True)
        output().print(f"# {purpose}", style="dim")


def not_evolving(run: RunSnapshot) -> GaitsimError:
    """Return the error for a run that is not evolving: the run's own failure, if it failed."""
    return run.failure or RunError(
        f"the run {run.path} is not evolving",
        remedy=f"show it: {command('show', run.path)}; or continue it: "
        f"{command('resume', run.path, '--detach')}",
    )


def find_evolving(reference: str) -> RunSnapshot:
    """Return a run; a background run even if its folder was deleted."""
    places = [Path(place) for place in (reference, RUNS / reference) if reference]
    for path in places:
        if background_state(path):
            return RunSnapshot(path)
    try:
        return RunSnapshot(find_run(reference))
    except RunError:
        failures = [failure for path in places if (failure := last_failure(path))]
        if failures:
            raise failures[0] from None
        raise
