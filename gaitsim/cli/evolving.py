"""Evolve a run from the command line, with progress, Ctrl-C and a final summary."""

import os
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

import numpy as np

from gaitsim.cli.cluster import warn
from gaitsim.cli.progress import display, row_of, snapshot_of
from gaitsim.cli.summary import summarise
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import Interrupts, interruptible
from gaitsim.console.printing import notice, status
from gaitsim.console.streams import results
from gaitsim.evaluation import Executor
from gaitsim.experiment import Overrides
from gaitsim.registry.entry_points import interrupted_plugin
from gaitsim.runs.files.folder import command
from gaitsim.runs.files.history import row
from gaitsim.runs.session import Session
from gaitsim.runs.writer import RunWriter

SLOW = 1.0  # seconds; shorter preparations are not reported


def evolve_run(
    path: Path,
    *,
    workers: int | None,
    json: bool,
    cluster: Executor | None = None,
    overrides: Overrides | None = None,
    generations: int | None = None,
    any_version: bool = False,
) -> None:
    """Evolve the run in `path` from its last generation, and print a summary.

    Exits with code 130 if the user stops the run.
    """
    with interruptible() as interrupts:
        try:
            writer = RunWriter.open(
                path, overrides=overrides, generations=generations, any_version=any_version
            )
            with Session(writer, workers=workers, cluster=cluster, on_warning=warn) as session:
                if writer.warning:
                    warn(writer.warning)
                reason = _evolve(session, json, interrupts)
        except KeyboardInterrupt:
            _exit_immediately(path)
    if interrupts.requested and not reason:
        notice(f"Stopped and saved. Continue with: {command('resume', path)}")
        sys.exit(INTERRUPTED)
    summarise(path, reason, json, workers)


def _exit_immediately(path: Path) -> NoReturn:
    """Exit immediately; the run folder is complete at any time."""
    working = interrupted_plugin()
    if working:
        notice(f"When the run was stopped, {working}.")
    notice(f"Stopped at the last saved generation. Continue with: {command('resume', path)}")
    if all(thread.daemon or thread is threading.main_thread() for thread in threading.enumerate()):
        sys.exit(INTERRUPTED)
    # A normal exit would wait for threads, which compiled code may keep busy.
    for stream in (results(), sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(INTERRUPTED)


def _evolve(session: Session, json: bool, interrupts: Interrupts) -> str:
    """Evolve until a stop condition holds or the user stops; return the condition, or ''."""
    writer = session.writer
    experiment, last = writer.experiment, writer.last
    rows, first = (writer.run.history, writer.run.first_comparable) if last else ({}, 1)
    known = snapshot_of(last, experiment, rows=rows, scored_from=first)
    shown = display(writer.path, known, json)
    if writer.done:
        return writer.done
    name = experiment.entries["organism"].name
    start = time.perf_counter()
    with status(f"Preparing {name}: the first run compiles its kernels …"):
        session.prepare()
    seconds = time.perf_counter() - start
    if seconds > SLOW:
        notice(f"Prepared {name} in {seconds:.1f} s.")
    if writer.reevaluates and last is not None:
        with status(f"Re-evaluating the population of generation {last.number} …"):
            session.reevaluate()
    if writer.changes:
        first_changed = last.number + 1 if last else 1
        rescored = any(change.reevaluates for change in writer.changes)
        reevaluated = None
        if rescored and writer.last is not None:
            rows = {name: np.array([value]) for name, value in row(writer.last).items()}
            reevaluated = snapshot_of(writer.last, experiment, rows=rows)
        shown.start_stage(writer.stage, first_changed, [*map(str, writer.changes)], reevaluated)
    try:
        with shown:
            interrupts.deferred, interrupts.on_request = True, shown.stopping
            for generation in session.evolve():
                snapshot = snapshot_of(generation, experiment)
                shown.update(snapshot, [row_of(generation, snapshot)])
                if generation.stop or interrupts.requested:
                    return generation.stop
    finally:
        interrupts.deferred = False
    return ""
