"""One function over many tasks: in this thread, in threads, in processes, on a cluster.

What an executor is given and gives back is picklable: a function of a module, or a
`functools.partial` of one, tasks and results. `Portable` is how an experiment travels.
"""

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from typing import Self, TypeVar

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment

Task = TypeVar("Task")
Result = TypeVar("Result")

MAX_ATTEMPTS = 3
"""How often a task may end its worker before it is given up."""


class WorkerLostError(GaitsimError):
    """A task ended each worker that it was given to."""


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Executor(ABC):
    """Where tasks are done; a context manager that ends what it began.

    A task that is lost with its worker is done again, by another one.

    Attributes:
        workers: how many tasks are done at a time.
    """

    workers: int = 1

    @abstractmethod
    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Do the tasks, begun in their order; place and result of each as it is done.

        What the function raises is raised here. Whoever stops iterating drops the rest.

        Raises:
            WorkerLostError: a task ended its worker again and again.
            GaitsimError: the workers cannot be reached any more.
        """

    def map(self, function: Callable[[Task], Result], tasks: Sequence[Task]) -> list[Result]:
        """The results of all tasks, in the tasks' order.

        Raises:
            WorkerLostError: a task ended its worker again and again.
            GaitsimError: the workers cannot be reached any more.
        """
        results = dict(self.each(function, tasks))
        return [results[place] for place in range(len(tasks))]

    def check(self, experiments: Iterable[Experiment]) -> None:  # noqa: B027 - few need it
        """See that the workers have the packages of experiments, in the versions of here.

        Raises:
            GaitsimError: they have not; names each package and both versions.
        """

    @abstractmethod
    def close(self) -> None:
        """End the workers. What they are still doing is dropped."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class SerialExecutor(Executor):
    """In this thread, one task after the other."""

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Do each task when its result is asked for."""
        for place, task in enumerate(tasks):
            yield place, function(task)

    def close(self) -> None:
        """There is nothing to end."""


class ThreadExecutor(Executor):
    """In threads of this process, for work that releases the interpreter's lock.

    Args:
        workers: how many.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool = ThreadPoolExecutor(workers, "gaitsim")

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Hand all tasks to the threads."""
        places = {self._pool.submit(function, task): place for place, task in enumerate(tasks)}
        try:
            while places:
                for future in wait(places, return_when=FIRST_COMPLETED).done:
                    yield places.pop(future), future.result()
        finally:
            for future in places:
                future.cancel()

    def map(self, function: Callable[[Task], Result], tasks: Sequence[Task]) -> list[Result]:
        """The results in order; less to do than with `each`, for tasks of a millisecond."""
        return list(self._pool.map(function, tasks))

    def close(self) -> None:
        """Drop what is not begun. A thread ends when what it does is done."""
        self._pool.shutdown(wait=False, cancel_futures=True)
