"""Evaluate a population in chunks, in this process or on an executor.

The score of an individual depends only on its own genome. The result is therefore identical for
any number of chunks, in whatever order they finish. Workers get a chunk in parts of the worlds if
it takes long; its scores are combined here when all parts are finished, in the order of the worlds.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from itertools import islice
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.chunking import Scheduler, split_indices
from gaitsim.evaluation.executors import (
    Executor,
    Result,
    Task,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.processes import OnWarning, ProcessExecutor
from gaitsim.evaluation.scoring import (
    Evaluation,
    combine_worlds,
    evaluate,
    evaluate_worlds,
    join_evaluations,
)
from gaitsim.evaluation.serialized import SerializedExperiment, prepare
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_context
from gaitsim.registry.kernel_cache import missing_cache

# Individuals per chunk for a compiled body: few enough for its arrays to fit into the cache, but
# enough to outweigh the calls of Python and NumPy, which hold the interpreter's lock. Best of 120
# on two cores of a Xeon: 200 spiders take 4.0 ms in chunks of 100, 4.6 ms in chunks of 50.
IN_CACHE = 100

LONG = 0.1  # seconds; populations that take longer are always shared among all threads
AGAIN = 32  # populations after which a way that was slower is measured again

# The C library of Linux returns memory to the system that exceeds twice the largest block that was
# ever freed. One large block, never touched, makes it keep the memory of a chunk for the next one:
# without it, 100 recurrence spiders on one core cause 1,430 page faults, which take half the time.
KEPT = 2**24  # bytes


class _Ways:
    """Ways to divide a population among threads of this process, chosen by their measured times.

    Two threads of one core compute vectors hardly faster than one, and waking a thread takes as
    long as moving 20 spiders. With all threads, 100 spiders of the preset spider-recurrence took
    1.35 times as long as with one on an AMD EPYC, and 0.6 times as long on an Intel Xeon.

    Args:
        threads: number of threads.
    """

    def __init__(self, threads: int) -> None:
        self._ways = [
            (number, size)
            for size in (IN_CACHE, IN_CACHE // 2, 2 * IN_CACHE)
            for number in dict.fromkeys((threads, 1))
        ]
        self._seconds: dict[tuple[int, int, int], float] = {}  # by individuals, threads, chunk
        self._count = 0

    def choose(self, individuals: int) -> tuple[int, int]:
        """Return the number of threads and the largest chunk for a population of this size."""
        known = {way: self._seconds.get((individuals, *way), math.inf) for way in self._ways}
        best = min(self._ways, key=known.__getitem__)
        if known[best] > LONG:
            return self._ways[0]
        self._count += 1
        again = self._ways[self._count // AGAIN % len(self._ways)]
        untried = next((way for way in self._ways if known[way] == math.inf), best)
        return again if self._count % AGAIN == 0 else untried

    def learn(self, individuals: int, way: tuple[int, int], seconds: float) -> None:
        """Note a time; a longer one than before counts little, as other programs only add time."""
        before = self._seconds.get((individuals, *way), seconds)
        self._seconds[individuals, *way] = min(seconds, 1.05 * before)


class Evaluator:
    """Scores populations of one experiment; a context manager that stops its workers on exit.

    A body that releases the global interpreter lock moves in threads. Any other body moves in
    worker processes if they are faster than this process.

    Args:
        experiment: experiment with the body and fitness to use.
        workers: number of threads or worker processes; None for one per core. Worker processes
            are limited to the number of cores, but never to fewer than two.
        on_warning: called with a message for the user if a worker died, or if requested workers
            remain idle or exceed the cores.
        cluster: executor of a cluster, used for large populations; the caller closes it.

    Attributes:
        on_share: called with the share of the population that is scored, from 0 to 1.
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
        self.on_share: Callable[[float], object] = lambda share: None
        threads = experiment.organism.threads
        number = workers or cores()
        if experiment.outside and not (workers or threads):
            number = 1  # a function that a user passes may be quick, or have side effects
        self._threads = 1 if not threads else cores() if cluster else number
        self._pool = ThreadPoolExecutor(self._threads, "gaitsim") if self._threads > 1 else None
        self._ways = _Ways(self._threads)
        self._processes = None
        if not (cluster or threads or number == 1):
            # More processes than cores only start more slowly: on two cores, 32 processes took ten
            # times as long to start as two. A single core also gets two, so that runs with worker
            # processes can be tested on it.
            most = max(2, cores())
            if number > most:
                on_warning(f"{number:,} workers exceed the cores of this machine; {most} are used")
            self._processes = ProcessExecutor(min(number, most), on_warning)
        self._requested = cluster is not None or workers is not None
        self._scheduler = self._task_scheduler = None
        if remote := cluster or self._processes:
            self._scheduler = Scheduler(self._threads, remote, self._requested, on_warning)
            self._task_scheduler = Scheduler(self._threads, remote, self._requested)
        self._serialized = SerializedExperiment(experiment, remote=cluster is not None)
        # A genome with its generation and evaluation in this process, to compare with a worker's.
        self._unchecked: tuple[Genomes, int, Evaluation] | None = None

    @property
    def workers(self) -> int:
        """Number of workers that share a population; on a cluster, this number may change."""
        return self._scheduler.remote.workers if self._scheduler else self._threads

    @property
    def remote(self) -> bool:
        """Whether the workers are other processes: then few large requests are faster."""
        return self._scheduler is not None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        if self._processes is not None:
            self._processes.close()

    def prepare(self, individuals: int | None = None) -> None:
        """Compile kernels and check workers, so that the first generation is not delayed.

        Args:
            individuals: size of the first population; None for the size in the experiment.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: remote workers lack a package, or have a different version of it; or a
                Python function cannot be sent to workers.
        """
        np.empty(KEPT, np.uint8)
        prepare(self.experiment)
        if warning := missing_cache():
            self._on_warning(warning)
        if self._scheduler is not None:
            self._serialized.check()
            self._scheduler.remote.check([self.experiment])
            if not self.experiment.body_outside:
                size = individuals or self.experiment.individuals
                self._scheduler.time_batches(self._seconds, size)

    def _seconds(self, individuals: int) -> float:
        start = time.perf_counter()
        prepare(self.experiment, individuals)  # in one world
        return (time.perf_counter() - start) * (self.experiment.worlds.count or 1)

    def evaluate(self, genomes: Genomes, generation: int = 1) -> Evaluation:
        """Score genomes, (population, genes), in the worlds of a generation.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: the same individuals repeatedly killed their worker, or the connection
                to remote workers was lost.
        """
        scheduler = self._scheduler
        if scheduler is None or scheduler.cost_model.first or not self.experiment.body_outside:
            return self._evaluate(genomes, generation)
        # The batches that are timed belong to the population: a user's function is called for no
        # other genomes.
        parts: list[Evaluation] = []

        def seconds(individuals: int) -> float:
            first = sum(len(part.scores) for part in parts)
            start = time.perf_counter()
            parts.append(
                evaluate(self.experiment, genomes[first : first + individuals], generation)
            )
            return time.perf_counter() - start

        scheduler.time_batches(seconds, len(genomes), parts=3)
        self._unchecked = genomes[:1], generation, parts[0]
        rest = genomes[sum(len(part.scores) for part in parts) :]
        parts += [self._evaluate(rest, generation)] if len(rest) else []
        return join_evaluations(self.experiment, parts)

    def _evaluate(self, genomes: Genomes, generation: int) -> Evaluation:
        """Score genomes as the scheduler decides."""
        scheduler, chunks = self._scheduler, 1
        if scheduler is not None:
            with self._explain_lost_workers():
                chunks = scheduler.chunks(len(genomes))
        if scheduler is not None and chunks > 1:
            populations = np.split(genomes, split_indices(len(genomes), chunks, self.workers))
            return self._evaluate_remotely(scheduler, populations, generation)
        start = time.perf_counter()
        way = threads, largest = self._ways.choose(len(genomes))
        cut = self._cut(genomes, threads, largest)
        worlds = self.experiment.worlds.count or 1
        scored = self._scored([1 / (worlds * len(cut))])
        score = partial(
            evaluate, self.experiment, generation=generation, on_world=lambda: scored(0)
        )
        each = self._pool.map if self._pool and threads > 1 else map
        parts = list(each(score, cut))
        seconds = time.perf_counter() - start
        self._ways.learn(len(genomes), way, seconds)
        if scheduler is not None:
            scheduler.cost_model.learn(len(genomes), seconds, self._threads)
        return join_evaluations(self.experiment, parts)

    def _evaluate_remotely(
        self, scheduler: Scheduler, populations: Sequence[Genomes], generation: int
    ) -> Evaluation:
        """Score the chunks of a population on the workers."""
        worlds, individuals = self.experiment.worlds.count or 1, sum(map(len, populations))
        chunks = [(one, scheduler.split_worlds(len(one), worlds)) for one in populations]
        tasks = [(one, part) for one, parts in chunks for part in parts]
        shares = [len(one) / individuals / len(parts) for one, parts in chunks for _ in parts]
        results = self._map_remotely(
            scheduler, partial(_timed, generation), tasks, self._scored(shares)
        )
        self._compare_workers(scheduler)
        seconds = sum(seconds for seconds, _ in results)
        scheduler.cost_model.learn(individuals / len(chunks), seconds / len(chunks))
        join = partial(join_evaluations, self.experiment)
        found = (evaluation for _, evaluation in results)
        return join(
            [
                combine_worlds(self.experiment, join([*islice(found, len(parts))]))
                for _, parts in chunks
            ]
        )

    def _scored(self, shares: Sequence[float]) -> Callable[[int], None]:
        """Return a function that reports the share of a population that is scored.

        Args:
            shares: share of each part of the population, which the function adds by its index.
        """
        done = 0.0

        def scored(place: int) -> None:
            nonlocal done
            done += shares[place]
            self.on_share(min(done, 1.0))

        return scored

    def _compare_workers(self, scheduler: Scheduler) -> None:
        """Warn, once, if a user's function scores the first genome differently in a worker."""
        if self._unchecked is None:
            return
        genomes, generation, here = self._unchecked
        self._unchecked = None
        task = genomes, slice(None)
        [(_, found)] = self._map_remotely(scheduler, partial(_timed, generation), [task])
        there = combine_worlds(self.experiment, found)
        if np.array_equal(here.scores, there.scores):
            return
        code = " and the ".join(map(str, self.experiment.outside))
        self._on_warning(
            f"the {code} gave the same genome the score {here.scores[0]:g} here and "
            f"{there.scores[0]:g} in a worker, so results depend on the number of workers: it is "
            "random, or uses a variable of a module that was changed after the import"
        )

    def map(
        self, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        """Run a function over tasks on the same workers.

        Unless the user requested workers, worker processes start only when they would already have
        saved as much time as their start takes.

        Args:
            function: function of the experiment and a task, whose result depends only on these
                two. It must belong to a module, or be a `functools.partial` of such a function.
            tasks: picklable values, as the results must be. The function must not change them.

        Returns:
            The results in the order of the tasks.

        Raises:
            GaitsimError: the function raised this error, or a task repeatedly killed its worker.
        """
        scheduler = self._task_scheduler
        if scheduler is not None and len(tasks) > 1:
            with self._explain_lost_workers():
                shared = self._requested or scheduler.chunks(len(tasks)) > 1
            if shared:
                return self._map_remotely(scheduler, function, tasks)
        start = time.perf_counter()
        each = self._pool.map if self._pool else map
        results = list(each(partial(function, self.experiment), tasks))
        if scheduler is not None:
            scheduler.cost_model.learn(len(tasks), time.perf_counter() - start)
        return results

    def _cut(self, genomes: Genomes, threads: int, largest: int) -> list[Genomes]:
        """Split genomes into the chunks, at most `largest`, that this process evaluates."""
        if not self.experiment.organism.threads:
            return [genomes]
        rest = len(genomes) % (threads * largest)
        whole = len(genomes) - rest
        full = np.split(genomes[:whole], range(largest, whole, largest)) if whole else []
        return [*full, *np.array_split(genomes[whole:], min(threads, rest))] if rest else full

    def _map_remotely(
        self,
        scheduler: Scheduler,
        function: Callable[[Experiment, Task], Result],
        tasks: Sequence[Task],
        on_result: Callable[[int], object] = lambda place: None,
    ) -> list[Result]:
        context = plugin_context(
            self.experiment.entries["organism"], "moving a population in worker processes"
        )
        with self._explain_lost_workers(), context:
            applied = partial(_apply, self._serialized, function)
            return scheduler.remote.map(applied, tasks, on_result)

    @contextmanager
    def _explain_lost_workers(self) -> Iterator[None]:
        """Add the body and a remedy to the error about repeatedly lost workers."""
        try:
            yield
        except WorkerLostError as error:
            one = "workers=1" if self.experiment.outside else "--workers 1"
            raise GaitsimError(
                f"{error.what}, which moves {self.experiment.entries['organism']}",
                remedy=f"run with {one} to see the reason; fewer workers need less memory",
            ) from None


def _apply(
    serialized: SerializedExperiment, function: Callable[[Experiment, Task], Result], task: Task
) -> Result:
    return function(serialized.experiment, task)


def _timed(
    generation: int, experiment: Experiment, task: tuple[Genomes, slice]
) -> tuple[float, Evaluation]:
    """Return how long genomes moved in a part of the worlds, in seconds, and their evaluation."""
    start, (genomes, part) = time.perf_counter(), task
    evaluation = evaluate_worlds(experiment, genomes, generation, part=part)
    return time.perf_counter() - start, evaluation
