"""A population in chunks over an executor.

An individual's score depends on its own genome alone, so neither the number of chunks
nor the order in which they finish changes a bit of the result.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.chunking import Scheduler, cuts, measure_overhead
from gaitsim.evaluation.executors import (
    Executor,
    Result,
    SerialExecutor,
    Task,
    ThreadExecutor,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.processes import OnWarning, ProcessExecutor
from gaitsim.evaluation.scoring import Evaluation, evaluate, joined
from gaitsim.evaluation.serialized import SerializedExperiment, prepare
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_context

# Individuals a chunk of a compiled body: few enough for its arrays to stay in the cache, and for
# the memory allocator not to ask the system for them each time. 100 recurrence spiders on
# two cores take 1.7 ms so, 2.6 ms as two chunks; on one core 3.2 ms, 5.1 ms as one chunk. A
# power of two, as kernels that move as many lanes at once waste none: 100 flies of three starts
# take 54 ms, 64 ms in four chunks of 25.
IN_CACHE = 32


class Evaluator:
    """Scores populations of one experiment; a context manager that ends its workers.

    A body that releases the interpreter's lock is moved in threads, any other in worker
    processes where they are faster.

    Args:
        experiment: whose body and fitness to use.
        workers: how many work at a time; None for as many as there are cores. Worker
            processes are no more than these, but two at least.
        on_warning: called with a message for the user when a worker died, and when the workers
            asked for are idle or more than the cores.
        cluster: workers elsewhere, for what is worth the way; whoever made it ends it.
    """

    def __init__(
        self,
        experiment: Experiment,
        workers: int | None = None,
        on_warning: OnWarning = lambda text: None,
        cluster: Executor | None = None,
    ) -> None:
        self.experiment = experiment
        threads = experiment.organism.threads
        asked = workers or cores()
        self._local: Executor = SerialExecutor()
        if threads and (cluster or asked > 1):
            self._local = ThreadExecutor(cores() if cluster else asked)
        self._own = None
        if not (cluster or threads or asked == 1):
            # No more than cores: 1,000 on two took ten times as long as two, to begin 32 of them.
            # Two on a single core, too, so that runs there can be checked in the same way.
            most = max(2, cores())
            if asked > most:
                on_warning(
                    f"{asked:,} workers are more than the cores here can use; {most} are used"
                )
            self._own = ProcessExecutor(min(asked, most), on_warning)
        self._remote = cluster or self._own
        self._wanted = cluster is not None or workers is not None
        self._scheduler = Scheduler(self._local.workers, self.workers, self._wanted)
        # The same of other tasks, as if one were an individual.
        self._task_scheduler = Scheduler(self._local.workers, self.workers, self._wanted)
        self._paced = False
        self._on_warning = on_warning if self._wanted else None
        self._serialized = SerializedExperiment(experiment)

    @property
    def workers(self) -> int:
        """How many work at a time where a population is shared; those of a cluster come and go."""
        return (self._remote or self._local).workers

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._local.close()
        if self._own is not None:
            self._own.close()

    def prepare(self) -> None:
        """Do once what the first generation would otherwise pay for, such as compiling.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: workers elsewhere lack a package, or have it in another version.
        """
        prepare(self.experiment)
        if self._remote is not None:
            self._remote.check([self.experiment])
            start = time.perf_counter()
            prepare(self.experiment)  # once more: compiling is not what moving costs
            self._scheduler.cost_model.learn(1, time.perf_counter() - start)

    def evaluate(self, genomes: Genomes) -> Evaluation:
        """Score genomes, (population, genes).

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: workers died over the same individuals again and again, or those
                elsewhere cannot be reached any more.
        """
        chunks = self._chunks(len(genomes))
        if chunks > 1 and self._remote is not None:
            ends = cuts(len(genomes), chunks, self.workers)
            return self._there(self._remote, np.split(genomes, ends))
        start = time.perf_counter()
        parts = self._local.map(partial(evaluate, self.experiment), self._cut(genomes))
        seconds = time.perf_counter() - start
        self._scheduler.cost_model.learn(len(genomes), seconds, self._local.workers)
        return joined(self.experiment, parts)

    @property
    def elsewhere(self) -> bool:
        """Whether workers are other processes, which would rather be asked seldom."""
        return self._remote is not None

    def map(
        self, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        """Do something else with the experiment over the same workers.

        Worker processes that were not asked for are begun when they would have paid.

        Args:
            function: is called with the experiment and a task; a function of a module, or
                a `functools.partial` of one. What it gives depends on these two alone.
            tasks: picklable, as are the results. Both stay as they are.

        Returns:
            The results in the tasks' order.

        Raises:
            GaitsimError: the function did, or a task ended its workers again and again.
        """
        self._task_scheduler.workers = self.workers
        shared = self._wanted or self._task_scheduler.chunks(len(tasks)) > 1
        if self._remote is not None and shared and len(tasks) > 1:
            return self._over(self._remote, function, tasks)
        start = time.perf_counter()
        results = self._local.map(partial(function, self.experiment), tasks)
        self._task_scheduler.cost_model.learn(len(tasks), time.perf_counter() - start)
        return results

    def _cut(self, genomes: Genomes) -> list[Genomes]:
        """The chunks for this process."""
        if not self.experiment.organism.threads:
            return [genomes]
        workers = self._local.workers
        rest = len(genomes) % (workers * IN_CACHE)
        whole = len(genomes) - rest
        full = np.split(genomes[:whole], range(IN_CACHE, whole, IN_CACHE)) if whole else []
        return [*full, *np.array_split(genomes[whole:], min(workers, rest))] if rest else full

    def _chunks(self, individuals: int) -> int:
        """How many chunks workers get; 1 where they would not be faster."""
        if self._remote is None:
            return 1
        self._scheduler.workers = self.workers
        chunks = self._scheduler.chunks(individuals)
        if chunks > 1 and not self._paced:
            with self._naming():
                self._scheduler.overhead, self._paced = measure_overhead(self._remote), True
            chunks = self._scheduler.chunks(individuals)
        known = self._scheduler.cost_model.known
        if self._on_warning is not None and known and self._scheduler.plan(individuals) is None:
            one = self.workers == 1
            several = "1 worker" if one else f"{self.workers:,} workers"
            self._on_warning(
                f"{several} would not be faster here, where moving {individuals:,} individuals "
                f"takes {1000 * self._scheduler.local_seconds(individuals):.2f} ms; "
                + ("it idles" if one else "they idle")
            )
            self._on_warning = None
        return chunks

    def _there(self, remote: Executor, chunks: Sequence[Genomes]) -> Evaluation:
        results = self._over(remote, _timed, chunks)
        individuals = sum(map(len, chunks)) / len(chunks)
        seconds = sum(seconds for seconds, _ in results) / len(chunks)
        self._scheduler.cost_model.learn(individuals, seconds)
        return joined(self.experiment, [part for _, part in results])

    def _over(
        self,
        remote: Executor,
        function: Callable[[Experiment, Task], Result],
        tasks: Sequence[Task],
    ) -> list[Result]:
        entry = self.experiment.entries["organism"]
        with self._naming(), plugin_context(entry, "moving a population in worker processes"):
            return remote.map(partial(_apply, self._serialized, function), tasks)

    @contextmanager
    def _naming(self) -> Iterator[None]:
        """Where workers die again and again, name the body that they were for, and what to try."""
        try:
            yield
        except WorkerLostError as error:
            raise GaitsimError(
                f"{error.what}: moving {self.experiment.entries['organism']}",
                remedy="with --workers 1 the reason may show; fewer workers need less memory",
            ) from None


def _apply(
    serialized: SerializedExperiment, function: Callable[[Experiment, Task], Result], task: Task
) -> Result:
    return function(serialized.experiment, task)


def _timed(experiment: Experiment, genomes: Genomes) -> tuple[float, Evaluation]:
    start = time.perf_counter()
    evaluation = evaluate(experiment, genomes)
    return time.perf_counter() - start, evaluation
