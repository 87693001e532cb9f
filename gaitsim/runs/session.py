"""The evolution of one run: its writer, evaluator and search, opened and closed together.

open ─▶ prepare ─▶ re-evaluate, if a stage needs it ─▶ evolve ─▶ finished, stopped or failed
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator, Executor
from gaitsim.evolution import Generation, island_map
from gaitsim.runs.background import forget_failure
from gaitsim.runs.files.folder import EXPERIMENT, command
from gaitsim.runs.writer import RunWriter


class Session(ExitStack):
    """A run evolved by this process; a context manager that stops its workers and unlocks it.

    Errors raised in the block tell the user how to resume the run.

    Args:
        writer: writer of the run, which the session closes.
        workers: number of parallel workers; None for the default.
        cluster: executor of a cluster; the caller closes it.
        on_warning: callback for messages about workers.
    """

    def __init__(
        self,
        writer: RunWriter,
        *,
        workers: int | None = None,
        cluster: Executor | None = None,
        on_warning: Callable[[str], None] = lambda text: None,
    ) -> None:
        super().__init__()
        self.writer = writer
        self._workers, self._cluster, self._on_warning = workers, cluster, on_warning
        self._evaluator: Evaluator | None = None
        self.enter_context(writer)
        self.enter_context(_resumable(writer))
        forget_failure(writer.path)

    def prepare(self) -> Evaluator:
        """Start the workers and compile the body's kernels; a second call does nothing."""
        if self._evaluator is None:
            self._evaluator = self.enter_context(
                Evaluator(self.writer.experiment, self._workers, self._on_warning, self._cluster)
            )
            self._evaluator.prepare()
        return self._evaluator

    def reevaluate(self) -> None:
        """Re-evaluate the last generation if a new stage needs it."""
        self.writer.reevaluate(self.prepare().evaluate)

    def evolve(self) -> Iterator[Generation]:
        """Evolve until a stop condition holds; each generation is recorded before it is yielded."""
        if self.writer.done:
            return iter(())
        evaluator = self.prepare()
        return self.writer.evolve(evaluator.evaluate, island_map(evaluator))


@contextmanager
def _resumable(writer: RunWriter) -> Iterator[None]:
    """Add the command that resumes the run to errors raised in the block."""
    path = writer.path
    try:
        yield
    except GaitsimError as error:
        if (path / EXPERIMENT).exists():
            given = ", ".join(entry.argument for entry in writer.experiment.outside)
            how = f"gs.load({str(path)!r}).resume({given})" if given else command("resume", path)
            error.add_remedy(f"continue with: {how}")
        raise
