"""Evolving a run from the command line: progress, Ctrl-C, and the summary at the end."""

import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from gaitsim.cli.console import errors, notice
from gaitsim.cli.progress import Display, display
from gaitsim.cli.summary import summarise
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import evolve, stop_reason
from gaitsim.runs.directory import RunWriter

SLOW = 1.0  # seconds that may pass in silence


class Interrupted:
    """Whether the user wants the run to stop. The second wish is granted at once."""

    def __init__(self) -> None:
        self.wanted = False

    def __call__(self, _signal: int, _frame: FrameType | None) -> None:
        if self.wanted:
            raise KeyboardInterrupt
        self.wanted = True
        notice("Stopping after this generation; again to stop at once.")


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
    generations: int | None = None,
    any_version: bool = False,
) -> None:
    """Evolve the run in `path` from where it stands, and report.

    Exits with 130 when the user stopped it.

    Raises:
        GaitsimError: says what was wrong, and that the run can be gone on with.
    """
    with RunWriter(path, generations=generations, any_version=any_version) as writer:
        if writer.warning:
            notice(f"Warning: {writer.warning}")
        with _interrupts() as interrupted:
            reason = _evolve(writer, display(writer, json), workers, interrupted)
    resume_command = f"gaitsim resume {path}"
    if interrupted.wanted and not reason:
        notice(f"Stopped and saved. Go on with: {resume_command}")
        sys.exit(130)
    summarise(path, reason, json)


def _evolve(
    writer: RunWriter, shown: Display, workers: int | None, interrupted: Interrupted
) -> str:
    """Evolve until a stop condition or the user stops it; why it ended, '' for the user."""
    last = writer.last
    evolution = writer.experiment.evolution
    if last is not None:
        reason = stop_reason(evolution, last.number, last.progress)
        if reason:
            return reason
    with Evaluator(writer.experiment, workers) as evaluator:
        _prepare(evaluator)
        with shown:
            try:
                for generation in evolve(writer.experiment, evaluator.evaluate, last):
                    writer.record(generation)
                    shown.update(generation)
                    if generation.stop or interrupted.wanted:
                        return generation.stop
            except GaitsimError as error:
                error.remedy = "; ".join(
                    filter(None, [error.remedy, f"then go on with: gaitsim resume {writer.path}"])
                )
                raise
    return ""


def _prepare(evaluator: Evaluator) -> None:
    """Compile or load kernels, and say so while it takes long."""
    start = time.perf_counter()
    name = evaluator.experiment.entries["organism"].name
    console = errors()
    if console.is_terminal:
        with console.status(f"Preparing {name}: the first run compiles its kernels …"):
            evaluator.prepare()
    else:
        evaluator.prepare()
    seconds = time.perf_counter() - start
    if seconds > SLOW:
        notice(f"Prepared {name} in {seconds:.1f} s; compiled kernels are kept for the next run.")
