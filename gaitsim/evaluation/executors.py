"""The contract of workers: one function over many tasks, in processes or on a cluster.

Functions, tasks and results are picklable; a function is one of a module, or a
`functools.partial` of one. An experiment is sent as a `SerializedExperiment`.
"""

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Self, TypeVar

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment

Task = TypeVar("Task")
Result = TypeVar("Result")

MAX_ATTEMPTS = 3
"""How many workers a task may kill before it is given up."""


class WorkerLostError(GaitsimError):
    """A task killed each worker that got it."""


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Executor(ABC):
    """Runs tasks; a context manager that ends its workers.

    If a worker dies, another one repeats its task.

    Attributes:
        workers: how many tasks run at a time.
    """

    workers: int = 1

    @abstractmethod
    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Run tasks, started in order; yield index and result of each when it is finished.

        Exceptions of the function are raised here. Closing the iterator drops the rest.

        Raises:
            WorkerLostError: a task killed its worker again and again.
            GaitsimError: the workers cannot be reached any more.
        """

    def map(self, function: Callable[[Task], Result], tasks: Sequence[Task]) -> list[Result]:
        """Return the results of all tasks, in the tasks' order.

        Raises:
            WorkerLostError: a task killed its worker again and again.
            GaitsimError: the workers cannot be reached any more.
        """
        results = dict(self.each(function, tasks))
        return [results[place] for place in range(len(tasks))]

    def check(self, experiments: Iterable[Experiment]) -> None:  # noqa: B027 - few need it
        """Check that the workers have the packages of experiments in the local versions.

        Raises:
            GaitsimError: they do not; names each package and both versions.
        """

    @abstractmethod
    def close(self) -> None:
        """End the workers and drop their work."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
