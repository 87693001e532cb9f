"""A population in chunks over an executor.

An individual's score depends on its own genome alone, so neither the number of chunks
nor the order in which they finish changes a bit of the result.
"""

from collections.abc import Callable, Sequence
from functools import partial
from types import TracebackType
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import (
    Executor,
    Here,
    Result,
    Task,
    Threads,
    WorkerLostError,
    cores,
)
from gaitsim.evaluation.judge import Evaluation, joined, judge
from gaitsim.evaluation.portable import Portable, prepare
from gaitsim.evaluation.processes import Processes, Tell
from gaitsim.experiment import Experiment

# Individuals a chunk of a compiled body: few enough for its arrays to stay in the cache.
# 100 recurrence spiders on two cores take 1.7 ms so, 2.6 ms as two chunks.
IN_CACHE = 32


class Evaluator:
    """Scores populations of one experiment; a context manager that ends its workers.

    A body that releases the interpreter's lock is moved in threads, any other in worker
    processes when more than one worker is asked for.

    Args:
        experiment: whose body and fitness to use.
        workers: how many work at a time; None for every core where threads do, else 1.
        tell: is told, for the user, of workers that died.
    """

    def __init__(
        self,
        experiment: Experiment,
        workers: int | None = None,
        tell: Tell = lambda text: None,
    ) -> None:
        self.experiment = experiment
        self._threads = experiment.organism.threads
        self.workers = workers or (cores() if self._threads else 1)
        self._portable = Portable(experiment)
        self._executor: Executor
        if self.workers == 1:
            self._executor = Here()
        elif self._threads:
            self._executor = Threads(self.workers)
        else:
            self._executor = Processes(self.workers, tell)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._executor.close()

    def prepare(self) -> None:
        """Do once what the first generation would otherwise pay for, such as compiling.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
        """
        prepare(self.experiment)

    def map(
        self, function: Callable[[Experiment, Task], Result], tasks: Sequence[Task]
    ) -> list[Result]:
        """Do something else with the experiment over the same workers.

        Args:
            function: is called with the experiment and a task; a function of a module, or
                a `functools.partial` of one. What it gives depends on these two alone.
            tasks: picklable, as are the results.

        Returns:
            The results in the tasks' order.

        Raises:
            GaitsimError: the function did, or a task ended its workers again and again.
        """
        try:
            return self._executor.map(partial(_apply, self._portable, function), tasks)
        except WorkerLostError as error:
            entry = self.experiment.entries["organism"]
            raise GaitsimError(
                f"{error.what}: moving {entry}",
                remedy="with --workers 1 the reason may show; fewer workers need less memory",
            ) from None

    def evaluate(self, genomes: Genomes) -> Evaluation:
        """Score genomes, (population, genes).

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: worker processes died over the same individuals again and again.
        """
        rounds = -(-len(genomes) // (self.workers * IN_CACHE)) if self._threads else 1
        chunks = np.array_split(genomes, min(self.workers * rounds, len(genomes)))
        return joined(self.experiment, self.map(judge, chunks))


def _apply(
    portable: Portable, function: Callable[[Experiment, Task], Result], task: Task
) -> Result:
    return function(portable.experiment, task)
