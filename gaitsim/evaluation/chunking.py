"""Whether workers evaluate a population faster than this process, and in how many chunks.

    local:   first + (n − 1) · more
    remote:  latency + chunks · task + rounds · (first + (n / chunks − 1) · more)

with rounds = chunks / workers, at least 1. All are measured: `first` and `more` of the body, as
the first individual costs more than each further one if a body moves whole arrays, by batches
before the first generation and by each generation; `latency` and `task` of the workers, by tasks
that do nothing.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gaitsim.evaluation.executors import Executor

GAIN = 0.9
"""Workers get a population if they take less than this part of the local time."""

STARTUP = 1.5
"""Seconds that worker processes take to start: imports, and loading compiled code."""

DOUBT = 0.1
"""Seconds that workers have to save first if the user asked for them: on a busy machine a
single measurement is many times too long."""

PINGS = 32  # empty tasks, to measure the workers

BATCHES = (3, 24, 192)  # individuals in batches that are timed before the first population
CERTAIN = 0.05
"""Seconds of a batch that one interruption by another program does not double."""


@dataclass(frozen=True)
class Overhead:
    """What workers cost beyond the work itself, seconds.

    Attributes:
        latency: once a population.
        task: once a chunk.
    """

    latency: float
    task: float


PROCESS_OVERHEAD = Overhead(0.0005, 0.0003)
"""Of worker processes that have not started yet."""


def measure_overhead(executor: Executor) -> Overhead:
    """Measure the overhead of workers; starts them."""
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
    """The seconds that one worker takes over a population, by its size.

    Attributes:
        first: of the first individual, fixed costs of a call included.
        more: of each further individual; 0 until a batch was timed.
        known: whether a batch was timed.
    """

    def __init__(self) -> None:
        self.first = self.more = 0.0
        self.known = False

    def learn(self, individuals: float, seconds: float, workers: int = 1) -> None:
        """Learn from a measurement; later ones count for more, as genomes change.

        A lower one replaces the former: other load on the machine only adds to it. Up to twice
        the expected time is taken for such load, which slows the first individual, too: else a
        body that moves whole arrays would seem to gain by workers as soon as others want the
        cores.

        Args:
            individuals: how many were evaluated.
            seconds: how long it took.
            workers: how many threads of one process evaluated them.
        """
        if individuals <= 1:
            self.first = min(self.first, seconds) if self.first else seconds
            return
        expected = self.seconds(individuals, workers)
        if self.known and expected < seconds <= 2 * expected:
            slower = (1 + seconds / expected) / 2
            self.first, self.more = slower * self.first, slower * self.more
            return
        self.first = min(self.first, seconds)
        more = (seconds - self.first) * workers / (individuals - 1)
        self.more = min(more, (self.more + more) / 2) if self.known else more
        self.known = True

    def seconds(self, individuals: float, workers: int = 1) -> float:
        """Return the expected time; its lower bound while only one individual was timed."""
        return self.first + (individuals - 1) * self.more / workers


@dataclass(frozen=True)
class ChunkPlan:
    """A number of chunks, and the seconds that a population is expected to take so."""

    chunks: int
    seconds: float


def best_plan(
    individuals: int, workers: int, cost_model: CostModel, overhead: Overhead
) -> ChunkPlan:
    """Return the best number of chunks, two or more.

    Of plans that take about as long, return the one with most chunks: it evens out that some
    individuals take longer than others, and some workers.
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
    """Return where to cut a population into chunks, which workers take in order.

    The first round has equal, large chunks. Those of each further round are smaller, in equal
    steps, so that the last ones, where workers wait for the slowest, are short without more of
    them in all. After Tzeng and Ni, "Trapezoid self-scheduling" (1993).

    Args:
        individuals: size of the population.
        chunks: how many to make; fewer where one would be empty.
        workers: how many take them.

    Returns:
        The first individual of each chunk but the first, ascending.
    """
    rounds = -(-chunks // workers)
    weights = rounds - np.arange(chunks) // workers
    ends = np.rint(individuals * np.cumsum(weights) / weights.sum())
    return [int(end) for end in np.unique(ends) if 0 < end < individuals]


class Scheduler:
    """Decides, population by population, whether workers get it, and in how many chunks.

    Workers start once they would have saved as much time as their start takes, so that the
    start at most doubles what a run loses without them.

    Args:
        local: how many individuals this process evaluates at a time.
        remote: the workers; some may come or go.
        wanted: whether the user asked for workers, whatever their start costs.
        on_idle: called once, with a message for the user, if workers that the user asked for
            would not be faster.

    Attributes:
        cost_model: what is known of the body.
        overhead: of the workers; None until they are measured, when they first get work.
    """

    def __init__(
        self,
        local: int,
        remote: Executor,
        wanted: bool,
        on_idle: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.cost_model = CostModel()
        self.overhead: Overhead | None = None
        self._local, self.remote = local, remote
        self._threshold = DOUBT if wanted else STARTUP
        self._on_idle = on_idle if wanted else None
        self._lost = 0.0  # seconds that workers would have saved so far

    def local_seconds(self, individuals: int) -> float:
        """Return how long this process is expected to take over a population."""
        return self.cost_model.seconds(individuals, self._local)

    def plan(self, individuals: int) -> ChunkPlan | None:
        """Return how to cut a population for the workers; None if they would not be faster."""
        if individuals < 2:
            return None
        overhead = self.overhead or PROCESS_OVERHEAD
        plan = best_plan(individuals, self.remote.workers, self.cost_model, overhead)
        return plan if plan.seconds <= GAIN * self.local_seconds(individuals) else None

    def time_batches(self, seconds: Callable[[int], float], individuals: int) -> None:
        """Learn before the first population whether many individuals take longer than one.

        The time of one is no guide: a body that moves whole arrays takes as long over a hundred,
        and workers would repeat its fixed costs. So workers get the first population only if a
        batch took twice as long as one individual; else that population tells.

        Args:
            seconds: evaluates so many individuals here and returns how long it took.
            individuals: size of the first population, of which a batch is an eighth at most.
        """
        first = seconds(1)
        self.cost_model.learn(1, first)
        if individuals * first < STARTUP:
            return  # workers cannot start sooner than this process is done
        batch, taken = 1, first
        for batch in (size for size in BATCHES if 8 * size <= individuals):
            taken = seconds(batch)
            if taken >= max(2 * first, CERTAIN):
                break
        if taken >= 2 * first:
            self.cost_model.learn(batch, taken)

    def chunks(self, individuals: int) -> int:
        """Return into how many chunks to cut a population; 1 keeps it in this process.

        Raises:
            WorkerLostError: a worker died again and again while it was measured.
        """
        chunks = self._decide(individuals)
        if chunks > 1 and self.overhead is None:
            self.overhead = measure_overhead(self.remote)
            chunks = self._decide(individuals)
        if self._on_idle and self.cost_model.known and self.plan(individuals) is None:
            workers = self.remote.workers
            self._on_idle(
                ("1 worker" if workers == 1 else f"{workers:,} workers")
                + f" would not be faster: this process moves {individuals:,} individuals in "
                f"{1000 * self.local_seconds(individuals):.2f} ms"
            )
            self._on_idle = None
        return chunks

    def _decide(self, individuals: int) -> int:
        plan = self.plan(individuals)
        if plan is None:
            return 1
        self._lost += self.local_seconds(individuals) - plan.seconds
        return plan.chunks if self._lost > self._threshold else 1
