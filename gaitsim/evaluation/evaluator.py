"""A population in chunks over a `concurrent.futures` executor.

An individual's score depends on its own genome alone, so neither the number of chunks
nor the order in which they finish changes a bit of the result.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from types import TracebackType
from typing import Self

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.judge import Evaluation, joined, judge
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import containing

# Individuals a chunk of a compiled body: few enough for its arrays to stay in the cache.
# 100 recurrence spiders on two cores take 1.7 ms so, 2.6 ms as two chunks.
IN_CACHE = 32


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Evaluator:
    """Scores populations of one experiment; a context manager that ends its workers.

    A body that releases the interpreter's lock is moved in threads, any other in worker
    processes when more than one worker is asked for.

    Args:
        experiment: whose body and fitness to use.
        workers: how many work at a time; None for every core where threads do, else 1.
    """

    def __init__(self, experiment: Experiment, workers: int | None = None) -> None:
        self.experiment = experiment
        self._threads = experiment.organism.threads
        self.workers = workers or (cores() if self._threads else 1)
        self._executor: Executor | None = None
        if self.workers > 1 and self._threads:
            self._executor = ThreadPoolExecutor(self.workers, "gaitsim")
        elif self.workers > 1:
            self._executor = ProcessPoolExecutor(
                self.workers,
                multiprocessing.get_context("spawn"),
                _begin,
                (experiment.to_toml(),),
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._executor is None:
            return
        # Who wants to stop at once does not wait for the chunks that are being moved.
        at_once = isinstance(error, KeyboardInterrupt)
        in_processes = isinstance(self._executor, ProcessPoolExecutor)
        if at_once and in_processes:
            for child in multiprocessing.active_children():
                child.kill()
        self._executor.shutdown(wait=in_processes or not at_once, cancel_futures=True)

    def prepare(self) -> None:
        """Do once what the first generation would otherwise pay for, such as compiling.

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
        """
        prepare(self.experiment)

    def evaluate(self, genomes: Genomes) -> Evaluation:
        """Score genomes, (population, genes).

        Raises:
            PluginError: the body or the fitness fails or breaks its contract.
            GaitsimError: a worker process died.
        """
        try:
            parts = list(self._parts(genomes))
        except BrokenProcessPool:
            entry = self.experiment.entries["organism"]
            raise GaitsimError(
                f"a worker process died while moving {entry}",
                remedy="with --workers 1 the reason may show",
            ) from None
        return joined(self.experiment, parts)

    def _parts(self, genomes: Genomes) -> Iterable[Evaluation]:
        """The evaluations of the population's chunks, in order."""
        rounds = -(-len(genomes) // (self.workers * IN_CACHE)) if self._threads else 1
        chunks = np.array_split(genomes, min(self.workers * rounds, len(genomes)))
        if isinstance(self._executor, ProcessPoolExecutor):
            return self._executor.map(_judge_here, chunks)
        if self._executor is None:
            return map(partial(judge, self.experiment), chunks)
        return self._executor.map(partial(judge, self.experiment), chunks)


def prepare(experiment: Experiment) -> None:
    """Compile in this process what judging takes, or load it from the cache: judge one genome."""
    with containing(experiment.entries["organism"], "drawing genomes"):
        genome = experiment.organism.genome_space().random(1, np.random.default_rng(0))
    judge(experiment, genome)


_experiment: Experiment | None = None
_failure: GaitsimError | None = None


def _begin(toml: str) -> None:
    """Begin a worker process: its own experiment, made from the file's text."""
    global _experiment, _failure  # noqa: PLW0603 - a worker process has one, for its whole life
    begin_worker()
    try:
        _experiment = parse_experiment(toml, "the experiment")
        prepare(_experiment)
    except GaitsimError as error:  # raised here, it would only be known that the worker died
        _failure = error


def begin_worker() -> None:
    """Begin a worker process: stopping is its parent's affair, ending with it its own."""
    for number in (signal.SIGINT, signal.SIGTERM):  # the parent's to handle: it saves first
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker when its parent is gone, which may have been killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _judge_here(genomes: Genomes) -> Evaluation:
    if _failure is not None:
        raise _failure
    assert _experiment is not None, "the worker has begun"
    return judge(_experiment, genomes)
