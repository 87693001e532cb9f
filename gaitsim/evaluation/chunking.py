"""Whether it pays to share a population among workers, and in how many chunks.

    here:    first + (n − 1) · more
    shared:  latency + chunks · task + rounds · (first + (n / chunks − 1) · more)

with rounds = chunks / workers, at least 1. All are measured while a run goes on: `first` and `more`
of the body, as one individual costs more than each further one where a body moves whole
arrays; `latency` and `task` of the workers, by tasks that do nothing.
"""

import time
from dataclasses import dataclass

import numpy as np

from gaitsim.evaluation.executors import Executor

GAIN = 0.9
"""Sharing pays where it takes less than this part of the time."""

STARTUP = 1.5
"""Seconds that worker processes take to begin: imports, and loading compiled code."""

DOUBT = 0.1
"""Seconds that workers that were asked for have to save before they get anything: a busy
machine makes a single measurement many times too long."""

PINGS = 32  # tasks to measure the workers by


@dataclass(frozen=True)
class Overhead:
    """What sharing costs beyond the work, seconds.

    Attributes:
        latency: once a population.
        task: once a chunk.
    """

    latency: float
    task: float


PROCESS_OVERHEAD = Overhead(0.0005, 0.0003)
"""Of worker processes that are not begun yet."""


def measure_overhead(executor: Executor) -> Overhead:
    """The pace of workers, which are begun by it."""
    executor.map(_ping, range(PINGS))
    one = min(_seconds(executor, 1) for _ in range(5))
    all_ = min(_seconds(executor, PINGS) for _ in range(3))
    task = max(0.0, all_ - one) / (PINGS - 1)
    return Overhead(max(0.0, one - task), task)


def _ping(task: int) -> int:
    return task


def _seconds(executor: Executor, tasks: int) -> float:
    start = time.perf_counter()
    executor.map(_ping, range(tasks))
    return time.perf_counter() - start


class CostModel:
    """How long one worker takes over a population, by its size, as far as is known. Seconds.

    Attributes:
        known: whether any but a single individual was timed.
    """

    def __init__(self) -> None:
        self.first = self.more = 0.0
        self.known = False

    def learn(self, individuals: float, seconds: float, workers: int = 1) -> None:
        """Take in a measurement; later ones count for more, as genomes change.

        A lower one counts wholly: what else the machine does only adds to it.

        Args:
            individuals: how many were moved.
            seconds: it took.
            workers: among how many in one process they were shared.
        """
        if individuals <= 1:
            self.first = min(self.first, seconds) if self.first else seconds
            return
        self.first = min(self.first, seconds)
        more = (seconds - self.first) * workers / (individuals - 1)
        self.more = min(more, (self.more + more) / 2) if self.known else more
        self.known = True

    def seconds(self, individuals: float, workers: int = 1) -> float:
        """What to expect; while only one individual was timed, the most that it can be."""
        more = self.more if self.known else self.first
        return self.first + (individuals - 1) * more / workers


@dataclass(frozen=True)
class ChunkPlan:
    """A way to cut a population, and the seconds it is expected to take."""

    chunks: int
    seconds: float


def best_plan(
    individuals: int, workers: int, cost_model: CostModel, overhead: Overhead
) -> ChunkPlan:
    """The best number of chunks, two or more.

    Of those that take about as long the largest, as it evens out that some individuals take
    longer than others, and some workers.
    """
    wanted = {2, *(round(workers * part) for part in (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8, 12))}
    numbers = sorted({min(max(number, 2), individuals) for number in wanted})
    ways = [
        ChunkPlan(
            number,
            overhead.latency
            + number * overhead.task
            + max(1.0, number / workers) * cost_model.seconds(individuals / number),
        )
        for number in numbers
    ]
    least = min(way.seconds for way in ways)
    return max((way for way in ways if way.seconds <= 1.05 * least), key=lambda way: way.chunks)


def cuts(individuals: int, chunks: int, workers: int) -> list[int]:
    """Where to cut a population into chunks that are handed out in their order.

    All workers begin with equal, large ones. Each round's are smaller, in equal steps, so that
    those at the end, in which a worker that is late makes the others wait, are
    small, without more of them. After Tzeng and Ni, "Trapezoid self-scheduling" (1993).

    Args:
        individuals: how many there are.
        chunks: how many are wanted; where they would be less than an individual, they are fewer.
        workers: how many take them.

    Returns:
        The first individual of each chunk but the first, ascending.
    """
    rounds = -(-chunks // workers)
    weights = rounds - np.arange(chunks) // workers
    ends = np.rint(individuals * np.cumsum(weights) / weights.sum())
    return [int(end) for end in np.unique(ends) if 0 < end < individuals]


class Scheduler:
    """Decides, population by population, whether workers get it.

    Attributes:
        line: what is known of the body.
        pace: of the workers.
        workers: how many would work at a time, if it were shared. Some may come or go.

    Args:
        near: how many work at a time where the work is not shared.
        workers: at the beginning.
        wanted: whether workers were asked for, whatever their beginning costs.
    """

    def __init__(self, local: int, workers: int, wanted: bool) -> None:
        self.cost_model, self.overhead = CostModel(), PROCESS_OVERHEAD
        self._local, self.workers = local, workers
        self._threshold = DOUBT if wanted else STARTUP
        self._lost = 0.0  # seconds that workers would have saved so far

    def local_seconds(self, individuals: int) -> float:
        """Seconds that a population is expected to take where it is not shared."""
        return self.cost_model.seconds(individuals, self._local)

    def plan(self, individuals: int) -> ChunkPlan | None:
        """How to cut a population; None where workers would not be faster."""
        if individuals < 2:
            return None
        plan = best_plan(individuals, self.workers, self.cost_model, self.overhead)
        return plan if plan.seconds <= GAIN * self.local_seconds(individuals) else None

    def chunks(self, individuals: int) -> int:
        """Into how many chunks to cut a population; 1 where it is not to be shared yet.

        Workers are begun when they would have saved what that takes: so the beginning at
        the most doubles what a run loses without them.
        """
        # One individual does not tell what many take, unless that is very long.
        if not self.cost_model.known and self.local_seconds(individuals) < STARTUP:
            return 1
        plan = self.plan(individuals)
        if plan is None:
            return 1
        self._lost += self.local_seconds(individuals) - plan.seconds
        return plan.chunks if self._lost > self._threshold else 1
