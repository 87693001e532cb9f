"""A population in chunks over an executor.

An individual's score depends on its own genome alone, so neither the number of chunks
nor the order in which they finish changes a bit of the result.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.chunking import Scheduler, cuts
from gaitsim.evaluation.executors import (
    Executor,
    Result,
    Task,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.processes import OnWarning, ProcessExecutor
from gaitsim.evaluation.scoring import Evaluation, evaluate, joined
from gaitsim.evaluation.serialized import SerializedExperiment, prepare
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_context
from gaitsim.registry.kernel_cache import missing_cache

# Individuals in a chunk of a compiled body: few enough for its arrays to stay in the cache, and
# for the memory allocator not to ask the system for them each time, but not so few that NumPy's
# calls cost more than its work. On two cores, at best of 60, 200 spiders take 5.8 ms in chunks of
# 50, 6.7 in chunks of 32; on one core 100 recurrence spiders take 2.4 ms, 3.0 in a single chunk.
IN_CACHE = 50


class Evaluator:
    """Scores populations of one experiment; a context manager that ends its workers.

    A body that releases the interpreter's lock is moved in threads, any other in worker
    processes if they are faster.

    Args:
        experiment: whose body and fitness to use.
        workers: how many work at a time; None for as many as there are cores. Worker
            processes are at most as many as cores, but at least two.
        on_warning: called with a message for the user when a worker died, and when the workers
            asked for are idle or more than the cores.
        cluster: other workers for large populations; the caller closes them.
    """

    def __init__(
        self,
        experiment: Experiment,
        workers: int | None = None,
        on_warning: OnWarning = lambda text: None,
        cluster: Executor | None = None,
    ) -> None:
        self.experiment = experiment
        self._on_warning = on_warning
        threads = experiment.organism.threads
        asked = workers or cores()
        if experiment.in_python and not (cluster or threads):
            if asked > 1 and workers:
                code = " and the ".join(map(str, experiment.outside))
                on_warning(f"{workers:,} workers are not used: the {code} cannot be sent to them")
            asked = 1
        self._threads = 1 if not threads else cores() if cluster else asked
        self._pool = ThreadPoolExecutor(self._threads, "gaitsim") if self._threads > 1 else None
        self._own = None
        if not (cluster or threads or asked == 1):
            # Starting 32 of 1,000 processes on two cores took ten times as long as starting two.
            # Two on a single core, too, so that runs there can be checked in the same way.
            most = max(2, cores())
            if asked > most:
                on_warning(
                    f"{asked:,} workers are more than the cores here can use; {most} are used"
                )
            self._own = ProcessExecutor(min(asked, most), on_warning)
        self._wanted = cluster is not None or workers is not None
        self._scheduler = self._task_scheduler = None
        if remote := cluster or self._own:
            self._scheduler = Scheduler(self._threads, remote, self._wanted, on_warning)
            self._task_scheduler = Scheduler(self._threads, remote, self._wanted)
        self._serialized = SerializedExperiment(experiment)

    @property
    def workers(self) -> int:
        """How many work at a time if a population is shared; those of a cluster come and go."""
        return self._scheduler.remote.workers if self._scheduler else self._threads

    @property
    def elsewhere(self) -> bool:
        """Whether workers are other processes, for which few large requests are faster."""
        return self._scheduler is not None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        if self._own is not None:
            self._own.close()

    def prepare(self, individuals: int | None = None) -> None:
        """Do once what the first generation would otherwise pay for, such as compiling.

        Args:
            individuals: size of the first population; None for that of the experiment.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: remote workers lack a package, or have another version of it.
        """
        prepare(self.experiment)
        if warning := missing_cache():
            self._on_warning(warning)
        if self._scheduler is not None:
            self._scheduler.remote.check([self.experiment])
            self._scheduler.time_batches(self._seconds, individuals or self.experiment.individuals)

    def _seconds(self, individuals: int) -> float:
        start = time.perf_counter()
        prepare(self.experiment, individuals)
        return time.perf_counter() - start

    def evaluate(self, genomes: Genomes, generation: int = 1) -> Evaluation:
        """Score genomes, (population, genes), in the worlds of a generation.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: workers died over the same individuals again and again, or remote
                workers cannot be reached any more.
        """
        scheduler = self._scheduler
        if scheduler is None:
            return self._evaluate_locally(genomes, generation)
        with self._lost_workers_named():
            chunks = scheduler.chunks(len(genomes))
        if chunks == 1:
            return self._evaluate_locally(genomes, generation)
        populations = np.split(genomes, cuts(len(genomes), chunks, self.workers))
        results = self._map_remotely(scheduler, partial(_timed, generation), populations)
        seconds = sum(seconds for seconds, _ in results)
        scheduler.cost_model.learn(len(genomes) / len(results), seconds / len(results))
        return joined(self.experiment, [part for _, part in results])

    def _evaluate_locally(self, genomes: Genomes, generation: int) -> Evaluation:
        start = time.perf_counter()
        parts = self._map_locally(partial(_evaluate, generation), self._cut(genomes))
        if self._scheduler is not None:
            seconds = time.perf_counter() - start
            self._scheduler.cost_model.learn(len(genomes), seconds, self._threads)
        return joined(self.experiment, parts)

    def map(
        self, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        """Do something else with the experiment over the same workers.

        Worker processes that the user did not ask for start once they would have paid.

        Args:
            function: is called with the experiment and a task; a function of a module, or
                a `functools.partial` of one. Its result depends on these two alone.
            tasks: picklable, as are the results. Both stay as they are.

        Returns:
            The results in the tasks' order.

        Raises:
            GaitsimError: the function did, or a task ended its workers again and again.
        """
        scheduler = self._task_scheduler
        if scheduler is not None and len(tasks) > 1:
            with self._lost_workers_named():
                shared = self._wanted or scheduler.chunks(len(tasks)) > 1
            if shared:
                return self._map_remotely(scheduler, function, tasks)
        start = time.perf_counter()
        results = self._map_locally(function, tasks)
        if scheduler is not None:
            scheduler.cost_model.learn(len(tasks), time.perf_counter() - start)
        return results

    def _cut(self, genomes: Genomes) -> list[Genomes]:
        """Return the chunks for this process."""
        if not self.experiment.organism.threads:
            return [genomes]
        rest = len(genomes) % (self._threads * IN_CACHE)
        whole = len(genomes) - rest
        full = np.split(genomes[:whole], range(IN_CACHE, whole, IN_CACHE)) if whole else []
        return [*full, *np.array_split(genomes[whole:], min(self._threads, rest))] if rest else full

    def _map_locally(
        self, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        work = partial(function, self.experiment)
        return list(self._pool.map(work, tasks) if self._pool else map(work, tasks))

    def _map_remotely(
        self,
        scheduler: Scheduler,
        function: Callable[[Experiment, Task], Result],
        tasks: Sequence[Task],
    ) -> list[Result]:
        context = plugin_context(
            self.experiment.entries["organism"], "moving a population in worker processes"
        )
        with self._lost_workers_named(), context:
            return scheduler.remote.map(partial(_apply, self._serialized, function), tasks)

    @contextmanager
    def _lost_workers_named(self) -> Iterator[None]:
        """If workers die again and again, name the body that they moved, and what to try."""
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


def _evaluate(generation: int, experiment: Experiment, genomes: Genomes) -> Evaluation:
    return evaluate(experiment, genomes, generation)


def _timed(generation: int, experiment: Experiment, genomes: Genomes) -> tuple[float, Evaluation]:
    start = time.perf_counter()
    evaluation = evaluate(experiment, genomes, generation)
    return time.perf_counter() - start, evaluation
