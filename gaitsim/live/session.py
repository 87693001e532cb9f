"""The evolution of one run under the commands of another process."""

from pathlib import Path

from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.commands import CommandQueue
from gaitsim.live.protocol import Best, Command, State
from gaitsim.live.reporter import Reporter
from gaitsim.runs.writer import RunWriter


def evolve_live(
    path: Path,
    commands: CommandQueue,
    reporter: Reporter,
    *,
    overrides: Overrides | None = None,
    generations: int | None = None,
    workers: int | None = None,
    any_version: bool = False,
) -> State:
    """Evolve the run in `path` until it is finished or stopped.

    Args:
        path: folder of the run.
        commands: queue that is read between two generations; a `set` closes and reopens the run.
        reporter: receiver of every state, generation and error.
        overrides: options to change at the start, by key.
        generations: last generation to evolve; None for the number originally planned.
        workers: number of parallel workers.
        any_version: whether to resume with different versions of packages.

    Returns:
        'finished', 'stopped' or 'failed'.
    """
    changes, opened = overrides or {}, False
    rejected: GaitsimError | None = None
    while True:
        try:
            if not opened and not commands.wait_for_slot(reporter.state):
                reporter.state("stopped")
                return "stopped"
            reporter.state("preparing", error=rejected)
            rejected = None
            with RunWriter.open(
                path,
                overrides=changes,
                generations=None if opened else generations,
                any_version=any_version,
                workers=workers,
                on_warning=reporter.warning,
            ) as writer:
                changes, opened = {}, True
                ended = _evolve(writer, commands, reporter)
        except GaitsimError as error:
            if opened and changes:  # rejected before anything was changed
                rejected, changes = error, {}
                continue
            reporter.state("failed", error=commands.cause(error))
            return "failed"
        # Reported after the run is closed, as the reader may open it immediately.
        if isinstance(ended, str):
            reporter.state("finished", ended)
            return "finished"
        if ended.do == "stop":
            reporter.state("stopped")
            return "stopped"
        changes = ended.overrides


def _evolve(writer: RunWriter, commands: CommandQueue, reporter: Reporter) -> str | Command:
    """Evolve until a stop condition holds or a `stop` or `set` arrives, and return that."""
    reporter.run_opened(writer)
    if writer.done:
        reporter.evolution_starts(writer.last, _champion(writer))
        return writer.done
    writer.prepare()
    writer.reevaluate()
    reporter.evolution_starts(writer.last, _champion(writer))
    generations = writer.evolve()

    def report(state: State) -> None:
        if state != "running":
            writer.save()  # before waiting
        reporter.state(state)

    while True:
        command = commands.next(report)
        if command is not None:
            return command
        generation = next(generations)
        reporter.generation_finished(generation)
        if generation.stop:
            return generation.stop


def _champion(writer: RunWriter) -> Best | None:
    """Return the best individual with a comparable score, or None."""
    if writer.last is None or any(change.reevaluates for change in writer.changes):
        return None
    try:
        found = writer.run.individual()
    except RunError:
        return None
    if found.genome is None:
        return None
    return Best(found.generation, found.score, tuple(found.genome.tolist()))
