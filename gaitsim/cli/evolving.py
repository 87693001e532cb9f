"""Evolving a run from the command line: progress, Ctrl-C, and the summary at the end."""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

from gaitsim.cli.cluster import warn
from gaitsim.cli.console import errors, notice
from gaitsim.cli.progress import Display, display
from gaitsim.cli.streams import results
from gaitsim.cli.summary import summarise
from gaitsim.evaluation import Evaluator, Executor
from gaitsim.evolution import island_map
from gaitsim.experiment import Overrides
from gaitsim.registry.plugin_context import interrupted_plugin
from gaitsim.runs.files.folder import command, resumable
from gaitsim.runs.writer import RunWriter

SLOW = 1.0  # seconds that may pass in silence
INTERRUPTED = 130  # exit code, as shells give it


class Interrupted:
    """Whether the user wants the run to stop. The second wish is granted at once.

    So is the first one, as long as no generation is being made.
    """

    def __init__(self) -> None:
        self.wanted = False
        self.patient = False
        self.say: Callable[[], None] = lambda: None

    def __call__(self, _signal: int, _frame: FrameType | None) -> None:
        if self.wanted or not self.patient:
            raise KeyboardInterrupt
        self.wanted = True
        with suppress(OSError, RuntimeError):  # the stream may be in use, or closed
            self.say()


@contextmanager
def _interrupts() -> Iterator[Interrupted]:
    handler = Interrupted()
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield handler
    finally:
        for number, old in before.items():
            signal.signal(number, old)


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
    """Evolve the run in `path` from where it stands, and report.

    Exits with 130 when the user stopped it.

    Raises:
        GaitsimError: says what was wrong, and that the run can be gone on with.
    """
    with _interrupts() as interrupted:
        try:
            with RunWriter(
                path, overrides=overrides, generations=generations, any_version=any_version
            ) as writer:
                if writer.warning:
                    notice(f"Warning: {writer.warning}")
                reason = _evolve(writer, display(writer, json), workers, cluster, interrupted)
        except KeyboardInterrupt:
            _leave_at_once(path)
    if interrupted.wanted and not reason:
        notice(f"Stopped and saved. Go on with: {command('resume', path)}")
        sys.exit(INTERRUPTED)
    summarise(path, reason, json)


def _leave_at_once(path: Path) -> NoReturn:
    """End the program now: the run folder is whole at any time."""
    working = interrupted_plugin()
    if working:
        notice(f"When it was stopped, {working}.")
    notice(f"Stopped, as of the last saved generation. Go on with: {command('resume', path)}")
    if all(thread.daemon or thread is threading.main_thread() for thread in threading.enumerate()):
        sys.exit(INTERRUPTED)
    # Python would wait for threads, which compiled code may keep busy.
    for stream in (results(), sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(INTERRUPTED)


def _evolve(
    writer: RunWriter,
    shown: Display,
    workers: int | None,
    cluster: Executor | None,
    interrupted: Interrupted,
) -> str:
    """Evolve until a stop condition or the user stops it; why it ended, '' for the user."""
    if writer.done:
        return writer.done
    try:
        with (
            resumable(writer.path),
            Evaluator(writer.experiment, workers, warn, cluster) as evaluator,
        ):
            _prepare(evaluator)
            _begin_stage(writer, evaluator, shown)
            with shown:
                interrupted.patient, interrupted.say = True, shown.stopping
                for generation in writer.evolve(evaluator.evaluate, island_map(evaluator)):
                    shown.update(generation)
                    if generation.stop or interrupted.wanted:
                        return generation.stop
    finally:
        interrupted.patient = False
    return ""


def _prepare(evaluator: Evaluator) -> None:
    """Compile or load kernels, and say so while it takes long."""
    start = time.perf_counter()
    name = evaluator.experiment.entries["organism"].name
    with _status(f"Preparing {name}: the first run compiles its kernels …"):
        evaluator.prepare()
    seconds = time.perf_counter() - start
    if seconds > SLOW:
        notice(f"Prepared {name} in {seconds:.1f} s; compiled kernels are kept for the next run.")


def _begin_stage(writer: RunWriter, evaluator: Evaluator, shown: Display) -> None:
    """Judge the population anew where a change asks for it, and say that a stage begins."""
    if writer.reevaluates and writer.last is not None:
        with _status(f"Scoring the population of generation {writer.last.number} anew …"):
            writer.begin(evaluator.evaluate)
    if writer.changes:
        shown.begin_stage(writer)


def _status(text: str) -> AbstractContextManager[object]:
    """A line for a terminal, as long as the block takes."""
    console = errors()
    return console.status(text) if console.is_terminal else nullcontext()
