"""Evolve a run from the command line, or follow one that evolves elsewhere."""

import asyncio
import os
import signal
import sys
import threading
import time
from collections.abc import AsyncIterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal, NoReturn, Unpack

import numpy as np

from gaitsim.console import INTERRUPTED
from gaitsim.console.cluster import cluster, warn
from gaitsim.console.codes import challenge_as_start, read_challenge
from gaitsim.console.displays import RESTING, Display, Row, display, row_of
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, output, print_json, status
from gaitsim.console.run_end import summarise
from gaitsim.console.streams import results
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Executor
from gaitsim.experiment import Experiment
from gaitsim.live.process import RunProcess, background_state, detach, send
from gaitsim.live.protocol import RunCommand, Snapshot, snapshot_of
from gaitsim.live.slots import slot_count
from gaitsim.live.watcher import RunWatcher
from gaitsim.registry.entry_points import interrupted_plugin
from gaitsim.sharing.challenge import Challenge
from gaitsim.storage.background import (
    STATE_PREDICATES,
    create_runtime_folder,
    last_failure,
)
from gaitsim.storage.compatibility import check_start
from gaitsim.storage.creation import find_individual, without_symmetry
from gaitsim.storage.files.checkpoint import Champion, Start
from gaitsim.storage.files.folder import RUNS, command
from gaitsim.storage.files.history import row
from gaitsim.storage.growing import Rows
from gaitsim.storage.resume import ResumeOptions
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

SLOW = 1.0  # seconds; shorter preparations are not reported
FIRST_MOMENTS = 1.0  # seconds for which the command waits for an early failure in the background
PERIOD = 0.05  # seconds between checks

Place = Executor | Literal["background"] | None
"""The place where a run evolves: on a cluster, in the background, or in this process."""

INTEGER_COLUMNS = ("generation", "stage", "evaluations")


def starting_individual(experiment: Experiment, from_: str | Challenge | None) -> Champion | None:
    """Return the individual that `--from` names, or that of a challenge code already read."""
    if from_ is None:
        return None
    challenge = read_challenge(from_) if isinstance(from_, str) else from_
    start = find_individual(str(from_)) if challenge is None else challenge_as_start(challenge)
    start = without_symmetry(experiment, start)
    check_start(experiment, Start.of(start), f"--from {'CODE' if challenge else from_}")
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
                shown, reason = _display(writer, json), writer.done
                if not reason:
                    with _preparing(writer):
                        writer.prepare().on_share = shown.scored
                    _start_stage(writer, shown)
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


def _display(writer: RunWriter, json: bool) -> Display:
    """Return the display of a run as it was opened."""
    if writer.warning:
        warn(writer.warning)
    last = writer.last
    rows, first = (writer.run.history, writer.run.first_comparable) if last else ({}, 1)
    known = snapshot_of(last, writer.experiment, rows=rows, scored_from=first)
    return display(writer.path, known, json)


@contextmanager
def _preparing(writer: RunWriter) -> Iterator[None]:
    """Show that the block prepares the first generation, and how long a slow preparation took."""
    name = writer.experiment.entries["organism"].name
    start = time.perf_counter()
    with status(f"Preparing {name}: the first run compiles its kernels …"):
        yield
    seconds = time.perf_counter() - start
    if seconds > SLOW:
        notice(f"Prepared {name} in {seconds:.1f} s.")


def _start_stage(writer: RunWriter, shown: Display) -> None:
    """Re-evaluate the population if the options were changed, and show the new stage."""
    last = writer.last
    if writer.reevaluates and last is not None:
        with status(f"Re-evaluating the population of generation {last.number} …"):
            writer.reevaluate()
    if not writer.changes:
        return
    reevaluated = None
    if writer.last is not None and any(change.reevaluates for change in writer.changes):
        rows = {name: np.array([value]) for name, value in row(writer.last).items()}
        reevaluated = snapshot_of(writer.last, writer.experiment, rows=rows)
    first_changed = last.number + 1 if last else 1
    shown.start_stage(writer.stage, first_changed, [*map(str, writer.changes)], reevaluated)


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
        send(path, RunCommand("go"))
        state: str | None = "running"
    else:
        detach(path, workers=workers, **options)
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
        return RunSnapshot.find(reference)
    except RunError:
        failures = [failure for path in places if (failure := last_failure(path))]
        if failures:
            raise failures[0] from None
        raise


async def follow_run(path: Path, json: bool, *, in_background: bool) -> Snapshot:
    """Show a run until it ends or the user stops watching; return the last snapshot."""
    known = await asyncio.to_thread(RunWatcher(path).poll)
    process = RunProcess(path, initial=known, launch=False) if in_background else None
    follower = _Follower(path, display(path, known, json), known)
    following = asyncio.create_task(follower.follow(process or RunWatcher(path)))
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, following.cancel)
    await asyncio.wait([following])
    if process is not None:
        process.disconnect()
        await process.wait_ended()
    if not following.cancelled():
        following.result()
    return follower.last


class _Follower:
    """Shows the snapshots of a run, and each generation once.

    Args:
        path: folder of the run.
        shown: display that shows them.
        known: state of the run that the display already shows.

    Attributes:
        last: last snapshot shown.
    """

    def __init__(self, path: Path, shown: Display, known: Snapshot) -> None:
        self._path, self._shown = path, shown
        self._seen = known.generation
        self.last = known

    async def follow(self, snapshots: AsyncIterable[Snapshot]) -> None:
        """Show snapshots until the last one."""
        with self._shown:
            async for snapshot in snapshots:
                self._report(snapshot)
                rows = await asyncio.to_thread(self._rows, snapshot)
                self._shown.update(snapshot, rows)
                self.last = snapshot

    def _report(self, snapshot: Snapshot) -> None:
        before = self.last
        resting = snapshot.state != before.state and snapshot.state in RESTING
        if resting and not output().is_terminal:
            notice(RESTING[snapshot.state])
        if snapshot.error is not None and snapshot.state != "failed":
            self._shown.warn(str(snapshot.error))
        changes = [event for event in snapshot.events if event.kind == "stage"]
        if changes and snapshot.stage > before.stage:
            rescored = snapshot if snapshot.scored_from > before.scored_from else None
            texts = [event.text for event in changes]
            self._shown.start_stage(snapshot.stage, changes[0].generation, texts, rescored)

    def _rows(self, snapshot: Snapshot) -> Sequence[Row]:
        """Return the rows of the history that have not been shown.

        Rows that are needed from the run's folder but not yet there follow with a later snapshot.
        """
        rows, first = snapshot.rows, self._seen + 1
        # Only at rest, all rows are known to be in the folder.
        resting = snapshot.state in ("paused", "finished", "stopped")
        if snapshot.generation < first or not (rows or resting):
            return ()
        run = None
        if not rows or rows["generation"][0] > first:  # the snapshot left out earlier rows
            run = RunSnapshot(self._path)
            rows = run.history
        found = _as_dicts(rows, first) if rows else []
        if snapshot.islands and len(found) == 1 and first == snapshot.generation:
            found[0]["islands"] = list(snapshot.islands)
        elif snapshot.islands and found:
            bests = (run or RunSnapshot(self._path)).islands
            found = found[: max(len(bests) - self._seen, 0)]
            for one in found:
                one["islands"] = bests[one["generation"] - 1].tolist()
        self._seen += len(found)
        return found


def _as_dicts(rows: Rows, first: int) -> list[dict[str, Any]]:
    """Return the rows from generation `first`; a term that a row lacks is left out."""
    chosen = np.flatnonzero(rows["generation"] >= first)
    return [
        {
            name: int(values[index]) if name in INTEGER_COLUMNS else float(values[index])
            for name, values in rows.items()
        }
        for index in chosen
    ]
