"""Decide whether workers evaluate a population faster than this process, and in how many chunks.

The expected times of n individuals are

    local:   first + (n − 1) · more
    remote:  latency + chunks · task + rounds · (first + (n / chunks − 1) · more)

with rounds = chunks / workers, at least 1. All parameters are measured. `first` and `more` are the
costs of the first individual and of each further one; the first is more expensive if a body moves
whole arrays. They are measured with batches before the first generation, and in each generation.
`latency` and `task` are the costs of the workers, measured with tasks that do nothing.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gaitsim.evaluation.executors import Executor

GAIN = 0.9
"""Workers get a population if they take less than this share of the local time."""

STARTUP = 1.5
"""Seconds that worker processes take to start, mainly for imports and loading compiled code."""

MIN_SAVING = 0.1
"""Seconds that workers must save before they start, if the user requested them. It is not 0,
because a single measurement on a busy machine may be many times too long."""

PINGS = 32  # empty tasks, to measure the workers

BATCHES = (3, 24, 192)  # sizes of the batches that are timed before the first population
LONGEST = 5.0
"""Seconds that a task should take at most, so that a long generation shows its progress."""

RELIABLE = 0.05
"""Seconds from which a measurement is reliable: interruptions by other programs are shorter."""


@dataclass(frozen=True)
class Overhead:
    """The costs of workers beyond the work itself, seconds.

    Attributes:
        latency: cost per population.
        task: cost per chunk.
    """

    latency: float
    task: float


PROCESS_OVERHEAD = Overhead(0.0005, 0.0003)
"""The assumed overhead of worker processes that have not started yet."""


def measure_overhead(executor: Executor) -> Overhead:
    """Start the workers and measure their overhead."""
    executor.map(_ping, range(PINGS))
    single = min(_seconds(executor, 1) for _ in range(5))
    many = min(_seconds(executor, PINGS) for _ in range(3))
    task = max(0.0, many - single) / (PINGS - 1)
    return Overhead(max(0.0, single - task), task)


def _ping(task: int) -> int:
    return task


def _seconds(executor: Executor, tasks: int) -> float:
    start = time.perf_counter()
    executor.map(_ping, range(tasks))
    return time.perf_counter() - start


class CostModel:
    """The time in seconds that one worker takes for a population, by its size.

    Attributes:
        first: time of the first individual, including the fixed costs of a call.
        more: time of each further individual; 0 until a batch has been timed.
        known: whether a batch has been timed.
    """

    def __init__(self) -> None:
        self.first = self.more = 0.0
        self.known = False

    def learn(self, individuals: float, seconds: float, workers: int = 1) -> None:
        """Update the model with a measurement; later ones weigh more, because genomes change.

        A shorter time replaces the earlier one, because other programs only add time. A time of
        up to twice the expected one is attributed to other programs, which slow down the first
        individual, too. Otherwise workers would seem to speed up a body that moves whole arrays as
        soon as other programs use the cores.

        Args:
            individuals: number of individuals evaluated.
            seconds: time of the evaluation.
            workers: number of threads of this process that evaluated them.
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
        """Return the expected time; a lower bound until a batch has been timed."""
        return self.first + (individuals - 1) * self.more / workers


@dataclass(frozen=True)
class ChunkPlan:
    """A number of chunks, and the expected time of a population in seconds."""

    chunks: int
    seconds: float


def best_plan(
    individuals: int, workers: int, cost_model: CostModel, overhead: Overhead
) -> ChunkPlan:
    """Return the plan with the best number of chunks, at least two.

    Of plans with similar times, return the one with the most chunks, because it balances slow
    individuals and slow workers.
    """
    tried = {2, *(round(workers * part) for part in (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8, 12))}
    tried.add(math.ceil(cost_model.seconds(individuals) / LONGEST))
    numbers = sorted({min(max(number, 2), individuals) for number in tried})
    plans = [
        ChunkPlan(
            number,
            overhead.latency
            + number * overhead.task
            + max(1.0, number / workers) * cost_model.seconds(individuals / number),
        )
        for number in numbers
    ]
    least = min(plan.seconds for plan in plans)
    good = [plan for plan in plans if plan.seconds <= 1.05 * least]
    return max(good, key=lambda plan: plan.chunks)


def split_indices(individuals: int, chunks: int, workers: int) -> list[int]:
    """Return the indices at which to split a population into chunks, which workers take in order.

    The chunks of the first round are large and equal. Chunks shrink by equal steps from round to
    round: the last ones are short, so that workers hardly wait for the slowest one, without more
    chunks in total. Source: Tzeng and Ni 1993, "Trapezoid self-scheduling".

    Returns:
        The index of the first individual of each chunk except the first, ascending.
    """
    rounds = -(-chunks // workers)
    weights = rounds - np.arange(chunks) // workers
    ends = np.rint(individuals * np.cumsum(weights) / weights.sum())
    return [int(end) for end in np.unique(ends) if 0 < end < individuals]


class Scheduler:
    """Decides for each population whether workers evaluate it, and in how many chunks.

    Workers start only when they would already have saved as much time as their start takes.
    Therefore at most twice as much time is lost as with the best choice.

    Args:
        local: number of individuals that this process evaluates at the same time.
        remote: executor with the workers, whose number may change.
        requested: whether the user requested workers, regardless of their startup time.
        on_idle: called once, with a message for the user, if requested workers would not be
            faster.

    Attributes:
        cost_model: measured costs of the body.
        overhead: overhead of the workers; None until it is measured with their first work.
    """

    def __init__(
        self,
        local: int,
        remote: Executor,
        requested: bool,
        on_idle: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.cost_model = CostModel()
        self.overhead: Overhead | None = None
        self._local, self.remote = local, remote
        self._threshold = MIN_SAVING if requested else STARTUP
        self._on_idle = on_idle if requested else None
        self._lost = 0.0  # seconds that workers would have saved so far

    def local_seconds(self, individuals: int) -> float:
        """Return the time in seconds that this process is expected to take for a population."""
        return self.cost_model.seconds(individuals, self._local)

    def plan(self, individuals: int) -> ChunkPlan | None:
        """Return the best plan for the workers; None if they would not be faster."""
        if individuals < 2:
            return None
        overhead = self.overhead or PROCESS_OVERHEAD
        plan = best_plan(individuals, self.remote.workers, self.cost_model, overhead)
        return plan if plan.seconds <= GAIN * self.local_seconds(individuals) else None

    def time_batches(
        self, seconds: Callable[[int], float], individuals: int, parts: int = 8
    ) -> None:
        """Measure before the first population whether many individuals take longer than one.

        The time of one individual is not enough: a body that moves whole arrays may take the same
        time for a hundred, and workers would repeat its fixed costs. Workers therefore get the
        first population only if a batch takes at least twice as long as one individual. Otherwise
        the first population itself serves as the measurement.

        Args:
            seconds: function that evaluates a number of individuals in this process and returns
                the time it took.
            individuals: size of the first population.
            parts: a batch is at most this part of the population, such as an eighth.
        """
        first = seconds(1)
        self.cost_model.learn(1, first)
        if individuals * first < STARTUP:
            return  # this process finishes before workers could start
        batch, taken = 1, first
        for batch in (size for size in BATCHES if parts * size <= individuals):
            taken = seconds(batch)
            if taken >= max(2 * first, RELIABLE):
                break
        if taken >= 2 * first:
            self.cost_model.learn(batch, taken)

    def chunks(self, individuals: int) -> int:
        """Return the number of chunks for a population; 1 evaluates it in this process."""
        chunks = self._decide(individuals)
        if chunks > 1 and self.overhead is None:
            self.overhead = measure_overhead(self.remote)
            chunks = self._decide(individuals)
        if self._on_idle and self.cost_model.known and self.plan(individuals) is None:
            workers = self.remote.workers
            self._on_idle(
                ("1 worker" if workers == 1 else f"{workers:,} workers")
                + f" would not be faster: this process evaluates {individuals:,} individuals in "
                f"{1000 * self.local_seconds(individuals):.2f} ms"
            )
            self._on_idle = None
        return chunks

    def split_worlds(self, individuals: int, worlds: int) -> list[slice]:
        """Return the parts of the worlds in which tasks move a chunk, each for a few seconds."""
        seconds = self.cost_model.seconds(individuals)
        size = max(1, int(worlds * min(1.0, LONGEST / seconds))) if seconds else worlds
        return [slice(first, first + size) for first in range(0, worlds, size)]

    def _decide(self, individuals: int) -> int:
        plan = self.plan(individuals)
        if plan is None:
            return 1
        self._lost += self.local_seconds(individuals) - plan.seconds
        return plan.chunks if self._lost > self._threshold else 1
