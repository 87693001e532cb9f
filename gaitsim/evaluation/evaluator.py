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
from gaitsim.evaluation.chunking import Sharing, cuts, measured
from gaitsim.evaluation.executors import (
    Executor,
    Here,
    Result,
    Task,
    Threads,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.processes import Processes, Tell
from gaitsim.evaluation.scoring import Evaluation, joined, judge
from gaitsim.evaluation.serialized import Portable, prepare
from gaitsim.experiment import Experiment
from gaitsim.registry.plugin_context import Noting

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
        tell: is told, for the user, of workers that died, and that those asked for idle or
            are more than there are cores.
        cluster: workers elsewhere, for what is worth the way; whoever made it ends it.
    """

    def __init__(
        self,
        experiment: Experiment,
        workers: int | None = None,
        tell: Tell = lambda text: None,
        cluster: Executor | None = None,
    ) -> None:
        self.experiment = experiment
        threads = experiment.organism.threads
        asked = workers or cores()
        self._near: Executor = Here()
        if threads and (cluster or asked > 1):
            self._near = Threads(cores() if cluster else asked)
        self._own = None
        if not (cluster or threads or asked == 1):
            # No more than cores: 1,000 on two took ten times as long as two, to begin 32 of them.
            # Two on a single core, too, so that runs there can be checked in the same way.
            most = max(2, cores())
            if asked > most:
                tell(f"{asked:,} workers are more than the cores here can use; {most} are used")
            self._own = Processes(min(asked, most), tell)
        self._far = cluster or self._own
        self._wanted = cluster is not None or workers is not None
        self._sharing = Sharing(self._near.workers, self.workers, self._wanted)
        # The same of other tasks, as if one were an individual.
        self._mapping = Sharing(self._near.workers, self.workers, self._wanted)
        self._paced = False
        self._tell = tell if self._wanted else None
        self._portable = Portable(experiment)

    @property
    def workers(self) -> int:
        """How many work at a time where a population is shared; those of a cluster come and go."""
        return (self._far or self._near).workers

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._near.close()
        if self._own is not None:
            self._own.close()

    def prepare(self) -> None:
        """Do once what the first generation would otherwise pay for, such as compiling.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: workers elsewhere lack a package, or have it in another version.
        """
        prepare(self.experiment)
        if self._far is not None:
            self._far.check([self.experiment])
            start = time.perf_counter()
            prepare(self.experiment)  # once more: compiling is not what moving costs
            self._sharing.line.learn(1, time.perf_counter() - start)

    def evaluate(self, genomes: Genomes) -> Evaluation:
        """Score genomes, (population, genes).

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: workers died over the same individuals again and again, or those
                elsewhere cannot be reached any more.
        """
        chunks = self._chunks(len(genomes))
        if chunks > 1 and self._far is not None:
            ends = cuts(len(genomes), chunks, self.workers)
            return self._there(self._far, np.split(genomes, ends))
        start = time.perf_counter()
        parts = self._near.map(partial(judge, self.experiment), self._cut(genomes))
        seconds = time.perf_counter() - start
        self._sharing.line.learn(len(genomes), seconds, self._near.workers)
        return joined(self.experiment, parts)

    @property
    def elsewhere(self) -> bool:
        """Whether workers are other processes, which would rather be asked seldom."""
        return self._far is not None

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
        self._mapping.workers = self.workers
        shared = self._wanted or self._mapping.chunks(len(tasks)) > 1
        if self._far is not None and shared and len(tasks) > 1:
            return self._over(self._far, function, tasks)
        start = time.perf_counter()
        results = self._near.map(partial(function, self.experiment), tasks)
        self._mapping.line.learn(len(tasks), time.perf_counter() - start)
        return results

    def _cut(self, genomes: Genomes) -> list[Genomes]:
        """The chunks for this process."""
        if not self.experiment.organism.threads:
            return [genomes]
        workers = self._near.workers
        rest = len(genomes) % (workers * IN_CACHE)
        whole = len(genomes) - rest
        full = np.split(genomes[:whole], range(IN_CACHE, whole, IN_CACHE)) if whole else []
        return [*full, *np.array_split(genomes[whole:], min(workers, rest))] if rest else full

    def _chunks(self, individuals: int) -> int:
        """How many chunks workers get; 1 where they would not be faster."""
        if self._far is None:
            return 1
        self._sharing.workers = self.workers
        chunks = self._sharing.chunks(individuals)
        if chunks > 1 and not self._paced:
            with self._naming():
                self._sharing.pace, self._paced = measured(self._far), True
            chunks = self._sharing.chunks(individuals)
        known = self._sharing.line.known
        if self._tell is not None and known and self._sharing.shares(individuals) is None:
            one = self.workers == 1
            several = "1 worker" if one else f"{self.workers:,} workers"
            self._tell(
                f"{several} would not be faster here, where moving {individuals:,} individuals "
                f"takes {1000 * self._sharing.alone(individuals):.2f} ms; "
                + ("it idles" if one else "they idle")
            )
            self._tell = None
        return chunks

    def _there(self, far: Executor, chunks: Sequence[Genomes]) -> Evaluation:
        results = self._over(far, _timed, chunks)
        individuals = sum(map(len, chunks)) / len(chunks)
        seconds = sum(seconds for seconds, _ in results) / len(chunks)
        self._sharing.line.learn(individuals, seconds)
        return joined(self.experiment, [part for _, part in results])

    def _over(
        self, far: Executor, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        entry = self.experiment.entries["organism"]
        with self._naming(), Noting(entry, "moving a population in worker processes"):
            return far.map(partial(_apply, self._portable, function), tasks)

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
    portable: Portable, function: Callable[[Experiment, Task], Result], task: Task
) -> Result:
    return function(portable.experiment, task)


def _timed(experiment: Experiment, genomes: Genomes) -> tuple[float, Evaluation]:
    start = time.perf_counter()
    evaluation = judge(experiment, genomes)
    return time.perf_counter() - start, evaluation
