"""The search of one run, as commands want it.

open ─▶ prepare ─▶ judge anew, if a stage asks for it ─▶ evolve ─▶ finished, stopped, failed
▲                                                        │
└───────────────────── a change of the experiment ───────┘
"""

from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import island_map
from gaitsim.experiment import Overrides
from gaitsim.live.commands import Change, Stop, Wishes
from gaitsim.live.protocol import State
from gaitsim.live.reporter import Reporter
from gaitsim.runs.files.folder import resumable
from gaitsim.runs.writer import RunWriter


def evolve_steered(
    path: Path,
    wishes: Wishes,
    reporter: Reporter,
    *,
    overrides: Overrides | None = None,
    generations: int | None = None,
    workers: int | None = None,
    any_version: bool = False,
) -> State:
    """Evolve the run in `path` until it is finished or stopped, and tell how it ended.

    Args:
        path: the run's folder.
        wishes: asked between two generations.
        reporter: told of everything.
        overrides: options to change to begin with, by key.
        generations: how far it is to go; None as far as planned.
        workers: how many work at a time.
        any_version: go on although a package has another version now.

    Returns:
        finished, stopped or failed.
    """
    first, changes = True, overrides
    while True:
        reporter.state("preparing")
        try:
            with RunWriter(
                path,
                overrides=changes,
                generations=generations if first else None,
                any_version=any_version,
            ) as writer:
                first, changes = False, None
                with resumable(path):
                    ended = _evolve(writer, wishes, reporter, workers)
        except GaitsimError as error:
            if not first and changes:  # refused before anything was changed
                reporter.refused(error)
                changes = None
                continue
            return _end(reporter, "failed", error=error)
        if isinstance(ended, Change):
            changes = ended.overrides
        elif isinstance(ended, Stop):
            return _end(reporter, "stopped")
        else:
            return _end(reporter, "finished", ended)


def _end(
    reporter: Reporter, state: State, reason: str = "", error: GaitsimError | None = None
) -> State:
    """Tell the end when the run is closed: whoever is told may open it at once."""
    reporter.state(state, reason, error)
    return state


def _evolve(
    writer: RunWriter, wishes: Wishes, reporter: Reporter, workers: int | None
) -> str | Stop | Change:
    """Evolve until the search is finished, why; or until something else is wished."""
    reporter.opened(writer)
    if writer.done:
        reporter.begins(writer.last, _champion(writer))
        return writer.done
    number = writer.last.number if writer.last else 0

    def warn(text: str) -> None:
        reporter.event(number, "warning", text)

    with Evaluator(writer.experiment, workers, warn) as evaluator:
        evaluator.prepare()
        writer.begin(evaluator.evaluate)
        reporter.begins(writer.last, _champion(writer))
        generations = writer.evolve(evaluator.evaluate, island_map(evaluator))
        while True:
            wish = wishes.granted(reporter.state)
            if wish is not None:
                return wish
            generation = next(generations)
            number = generation.number
            reporter.finished(generation)
            if generation.stop:
                return generation.stop


def _champion(writer: RunWriter) -> dict[str, Any] | None:
    """The best so far whose score can be compared with those to come; None where there is none."""
    if writer.last is None or any(change.reevaluates for change in writer.changes):
        return None
    try:
        found = writer.run.individual()
    except RunError:
        return None
    if found.genome is None:
        return None
    return {
        "generation": found.generation,
        "score": found.score,
        "genome": found.genome.tolist(),
    }
