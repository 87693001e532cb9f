"""The interface of executors, which run a function over many tasks in processes or on a cluster.

Functions, tasks and results must be picklable: a function must belong to a module, or be a
`functools.partial` of such a function. An experiment is sent as a `SerializedExperiment`.
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
"""Number of workers that a task may kill before it is abandoned."""


class WorkerLostError(GaitsimError):
    """Raised if a task killed every worker that ran it."""


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Executor(ABC):
    """Runs tasks on workers; a context manager that stops the workers on exit.

    If a worker dies, another worker repeats its task.

    Attributes:
        workers: number of tasks that run at the same time.
    """

    workers: int = 1

    @abstractmethod
    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Run tasks, started in order; yield the index and result of each as it finishes.

        Exceptions of the function are raised here. Closing the iterator drops the remaining tasks.
        """

    def map(
        self,
        function: Callable[[Task], Result],
        tasks: Sequence[Task],
        on_result: Callable[[int], object] = lambda place: None,
    ) -> list[Result]:
        """Return the results of all tasks, in the order of the tasks.

        Args:
            function: function of a task.
            tasks: the tasks.
            on_result: called with the index of each task as it finishes.
        """
        results = {}
        for place, result in self.each(function, tasks):
            results[place] = result
            on_result(place)
        return [results[place] for place in range(len(tasks))]

    def check(self, experiments: Iterable[Experiment]) -> None:  # noqa: B027 - optional
        """Check that the workers have the local versions of the packages that experiments use."""

    @abstractmethod
    def close(self) -> None:
        """Stop the workers and drop their tasks."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
