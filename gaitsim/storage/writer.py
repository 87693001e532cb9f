"""Evolve a run and write it to disk: generations are recorded one by one, and saved together.

open ─▶ prepare ─▶ re-evaluate, if a stage needs it ─▶ evolve ─▶ finished, stopped or failed
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property, partial
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Any, Self, Unpack

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator, Executor
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution import (
    Generation,
    ParallelMap,
    evolve,
    island_map,
    reevaluate,
    stop_reason,
)
from gaitsim.individual import Individual
from gaitsim.opening import is_folder
from gaitsim.registry.entry_points import contract_error
from gaitsim.storage.background import forget_failure
from gaitsim.storage.compatibility import versions
from gaitsim.storage.files import history
from gaitsim.storage.files.atomic import sweep, write_bytes, writing
from gaitsim.storage.files.checkpoint import (
    Champion,
    Checkpoint,
    write_champion,
    write_checkpoint,
)
from gaitsim.storage.files.folder import (
    CHAMPIONS,
    CHECKPOINT,
    EXPERIMENT,
    EXPORTS,
    PREVIOUS,
    champion_file,
    champion_generations,
    command,
    create_subfolder,
    deleted_or_moved,
)
from gaitsim.storage.files.records import RecordFiles
from gaitsim.storage.lock import RunLock
from gaitsim.storage.measured import write_measured
from gaitsim.storage.provenance import current_versions, write_provenance
from gaitsim.storage.resume import ResumeOptions, ResumePlan, plan_resume
from gaitsim.storage.snapshot import RunSnapshot

REASONS_KEPT = 1000
"""Maximum number of failure reasons in a checkpoint."""
PERIOD = 0.5
"""Longest time of computing that a killed process loses, besides the current generation, seconds.

Saving takes as long as evolving several generations of a quick body. A run is a function of its
folder, so that lost generations are evolved again, to the same bits.
"""


class RunWriter:
    """A run evolved by this process, which alone writes its folder.

    A context manager: it saves and unlocks the run on exit, and stops its workers. Errors raised in
    the block tell the user how to resume the run.

    Attributes:
        run: snapshot of the run when it was opened.
        experiment: experiment of the coming generations.
        last: last finished generation; None before the first.
        changes: changes of the experiment that start a stage; () if there are none.
        stage: stage of the next generation, counted from 1.
        warning: problems of the run that do not prevent it from continuing, or ''.
        reevaluates: whether the population still has to be re-evaluated for a new stage.
    """

    def __init__(
        self,
        run: RunSnapshot,
        plan: ResumePlan,
        files: RecordFiles,
        resources: ExitStack,
        new_evaluator: Callable[[], Evaluator],
    ) -> None:
        """Take over the resources that `open` opened."""
        self.path, self.run = run.path, run
        self.experiment, self.last, self.changes = plan.experiment, plan.last, plan.changes
        self.stage = len(plan.stages) + 1
        self.warning, self.reevaluates = plan.warning, plan.reevaluates
        self._start, self._stages = plan.start, plan.stages
        self._files, self._resources = files, resources
        self._new_evaluator = new_evaluator
        self._evaluator: Evaluator | None = None
        self._provenance_written = False
        self._unsaved: Generation | None = None
        self._best: Generation | None = None
        self._recorded, self._saved = -math.inf, time.monotonic()

    @classmethod
    def open(
        cls,
        path: Path,
        *,
        workers: int | None = None,
        cluster: Executor | None = None,
        on_warning: Callable[[str], None] = lambda text: None,
        **options: Unpack[ResumeOptions],
    ) -> Self:
        """Lock the run in `path`, and drop records after its checkpoint.

        Args:
            path: folder of the run.
            workers: number of parallel workers; None for the default.
            cluster: executor of a cluster; the caller closes it.
            on_warning: callback for messages about workers.
            options: changes from the next generation, which are written to the experiment.
        """
        with ExitStack() as resources:
            resources.callback(RunLock(path).release)
            own = filter(is_folder, (path / name for name in (CHAMPIONS, EXPORTS)))
            for folder in (path.absolute().parent, path, *own):
                sweep(folder)
            run = RunSnapshot(path, keep_damaged=True)
            plan = plan_resume(run, **options)
            done = plan.last.number if plan.last else 0
            files = resources.enter_context(RecordFiles(path, plan.experiment, done))
            if plan.edited:
                write_bytes(path / EXPERIMENT, plan.experiment.to_toml().encode(), follow=False)
            with writing(path):
                for number in champion_generations(path):
                    if number > done:
                        (path / champion_file(number)).unlink(missing_ok=True)
            forget_failure(path)
            new_evaluator = partial(Evaluator, plan.experiment, workers, on_warning, cluster)
            return cls(run, plan, files, resources.pop_all(), new_evaluator)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if isinstance(error, GaitsimError) and (self.path / EXPERIMENT).exists():
            given = ", ".join(entry.argument for entry in self.experiment.outside)
            how = f"gs.load({str(self.path)!r}).resume({given})"
            error.add_remedy(f"continue with: {how if given else command('resume', self.path)}")
        with self._resources, ExitStack() as closing:
            closing.callback(self._save_at_exit, error)
            if self._evaluator is not None:
                closing.push(self._evaluator)

    def _save_at_exit(self, error: BaseException | None) -> None:
        try:
            self.save()
        except RunError:
            if error is None:  # otherwise, the first error says why the run ends
                raise
        if error is None:
            with suppress(GaitsimError):  # the run is complete; commands then simulate it
                champion = self._champion
                if champion is not None:
                    write_measured(self.path, champion)

    @property
    def _champion(self) -> Individual | None:
        """The champion of the run, if it was evolved by this process or is known from before."""
        best = self._best
        if best is not None:
            return Individual.of_generation(self.experiment, best, best.best, self.path)
        return self.run.individual() if self.last and self.run.best_generation else None

    @property
    def done(self) -> str:
        """The stop condition that holds for the run; '' if none."""
        last = self.last
        if last is None:
            return ""
        evolution = self.experiment.evolution
        return stop_reason(evolution, last.number, last.progress, len(last.genomes))

    def prepare(self) -> Evaluator:
        """Start the workers and compile the body's kernels; a second call does nothing."""
        if self._evaluator is None:
            self._evaluator = self._new_evaluator()
            self._evaluator.prepare()
        return self._evaluator

    def reevaluate(self, evaluate: Evaluate | None = None) -> None:
        """Re-evaluate the population if the next stage needs it; further calls do nothing.

        No file is written.

        Args:
            evaluate: function that scores a population with `experiment`; None for the workers.
        """
        if self.reevaluates and self.last is not None:
            score = evaluate or self.prepare().evaluate
            self.last = reevaluate(self.experiment, self.last, score)
        self.reevaluates = False

    def evolve(
        self, evaluate: Evaluate | None = None, parallel_map: ParallelMap | None = None
    ) -> Iterator[Generation]:
        """Evolve until a stop condition holds; each generation is recorded before it is yielded.

        Args:
            evaluate: function that scores a population with `experiment`; None for the workers.
            parallel_map: map that evolves islands in parallel; None evolves them in this process,
                unless the workers are faster.
        """
        if self.done:
            return
        if evaluate is None:
            evaluator = self.prepare()
            evaluate, parallel_map = evaluator.evaluate, island_map(evaluator)
        self.reevaluate(evaluate)
        for generation in evolve(self.experiment, evaluate, self.last, self._start, parallel_map):
            self.record(generation)
            yield generation

    def record(self, generation: Generation) -> None:
        """Record a finished generation, and save it unless another one fits into the `PERIOD`.

        A champion, the last generation and the first one of this writer are always saved at once.
        """
        if self.reevaluates:
            raise ValueError("call reevaluate() before recording the first generation of a stage")
        values = history.row(generation)
        for name in generation.evaluation.terms:
            if not history.is_term(name):
                what = f"names a term {name!r}, which is a column of the history"
                allowed = f"other names than {', '.join(history.COLUMNS)}"
                raise contract_error(self.experiment.entries["fitness"], what, allowed)
        with self._explained():
            self._files.append(generation, values)
        self._unsaved = generation
        if not generation.progress.stagnation and math.isfinite(generation.progress.best_score):
            self._best = generation
        now = time.monotonic()
        seconds, self._recorded = now - self._recorded, now
        due = now + seconds > self._saved + PERIOD
        if due or generation.is_champion or generation.stop:
            self.save()

    def save(self) -> None:
        """Write the recorded generations: their records first, the checkpoint last.

        A process killed in between leaves records after the checkpoint, which are dropped when
        the run resumes. A save that failed or was interrupted is not repeated.
        """
        generation, self._unsaved = self._unsaved, None
        if generation is None:
            return
        with self._explained():
            self._files.flush()
            if not self._provenance_written:
                used = current_versions(self.experiment)
                write_provenance(self.path, generation.number, used)
                self._provenance_written = True
            if generation.is_champion:
                self._write_champion(generation)
            checkpoint = self._checkpoint(generation)
            write_checkpoint(self.path / CHECKPOINT, checkpoint, self.path / PREVIOUS)
        self._saved = time.monotonic()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Convert errors in the block to those of a run whose folder may have been deleted."""
        try:
            with writing(self.path):
                yield
        except RunError:
            if (self.path / EXPERIMENT).exists():
                raise
            raise deleted_or_moved(self.path) from None

    def _write_champion(self, generation: Generation) -> None:
        best = generation.best
        champion = Champion(
            **self._origin,
            generation=generation.number,
            genome=generation.genomes[best],
            score=float(generation.scores[best]),
            terms=generation.evaluation.terms_of(best),
        )
        create_subfolder(self.path, CHAMPIONS)
        write_champion(self.path / champion_file(generation.number), champion)

    def _checkpoint(self, generation: Generation) -> Checkpoint:
        evaluation, progress = generation.evaluation, generation.progress
        reasons = islice(evaluation.reasons.items(), REASONS_KEPT)
        return Checkpoint(
            **self._origin,
            generation=generation.number,
            evaluations=progress.evaluations,
            genomes=generation.genomes,
            scores=evaluation.scores,
            terms=evaluation.terms,
            reasons={str(index): reason for index, reason in reasons},
            stagnation=progress.stagnation,
            best_score=progress.best_score,
            threshold=progress.threshold,
            stages=self._stages,
            values=evaluation.values,
            state=dict(generation.state),
            finished=progress.finished,
        )

    @cached_property
    def _origin(self) -> dict[str, Any]:
        return {"experiment": self.experiment.to_toml(), "versions": versions(self.experiment)}
