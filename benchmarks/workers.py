"""The cost of dividing a population among threads, processes and Dask workers on this machine.

The benchmark prints the overhead of a chunk, and its effect on the walker, which benefits from
workers, on the spider, which does not, and on a Python function that takes 20 ms per genome. Dask
is left out if `distributed` is not installed.
"""

import importlib.util
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from processor import processor_seconds
from timing import medians, milliseconds, print_figure, print_machine, stopwatch, times

import gaitsim
from gaitsim.contracts import Genomes, RealSpace
from gaitsim.evaluation import Evaluator, Executor, evaluate
from gaitsim.evaluation.chunking import CostModel, Overhead, best_plan, measure_overhead
from gaitsim.evaluation.executors import Result, Task
from gaitsim.evaluation.processes import ProcessExecutor
from gaitsim.evolution import evolve, first_population
from gaitsim.experiment import Experiment, load_experiment

WORKERS = 2


class Threads(Executor):
    """Threads as an executor; evaluators run compiled bodies in threads."""

    def __init__(self) -> None:
        self.workers = WORKERS
        self._pool = ThreadPoolExecutor(WORKERS)

    def each(
        self, function: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the results in the order of the tasks."""
        yield from enumerate(self._pool.map(function, tasks))

    def close(self) -> None:
        """Shut down the threads."""
        self._pool.shutdown()


@contextmanager
def started_executors() -> Iterator[dict[str, Executor]]:
    """Start the executors, and yield them by name."""
    with ExitStack() as stack:
        found: dict[str, Executor] = {
            "threads": stack.enter_context(Threads()),
            "processes": stack.enter_context(ProcessExecutor(WORKERS)),
        }
        if importlib.util.find_spec("distributed") is not None:
            from gaitsim.evaluation.dask import DaskExecutor

            found["Dask"] = stack.enter_context(DaskExecutor("local", WORKERS))
        yield found


def population(experiment: Experiment) -> Genomes:
    """Return the first population of an experiment."""
    return first_population(experiment)


def serialisation_cost(experiment: Experiment, genomes: Genomes) -> tuple[float, int]:
    """Return the seconds to pickle and unpickle a chunk and its evaluation, and the bytes."""
    sent, answer = pickle.dumps(genomes, 5), pickle.dumps(evaluate(experiment, genomes), 5)
    evaluation = pickle.loads(answer)

    def work() -> None:
        pickle.loads(pickle.dumps(genomes, 5))
        pickle.loads(pickle.dumps(evaluation, 5))

    return medians(work, repeats=100)[0], len(sent) + len(answer)


def cost_model(experiment: Experiment, genomes: Genomes) -> CostModel:
    """Return the cost model of a body, learnt from two measurements."""
    found = CostModel()
    one, all_ = medians(
        lambda: evaluate(experiment, genomes[:1]), lambda: evaluate(experiment, genomes), repeats=1
    )
    found.learn(1, one)
    found.learn(len(genomes), all_)
    return found


def print_chunks(name: str, executors: dict[str, Executor], overheads: dict[str, Overhead]) -> None:
    """Print the overhead of a chunk of the size that gaitsim chooses."""
    experiment = load_experiment(name)
    genomes = population(experiment)
    known = cost_model(experiment, genomes)
    print(
        f"\n{name}: {len(genomes)} individuals, {milliseconds(known.seconds(len(genomes)))} alone"
    )
    seconds, size = serialisation_cost(experiment, np.array_split(genomes, 2 * WORKERS)[0])
    print_figure("  pickling a quarter and its scores", milliseconds(seconds), f"{size:,} bytes")
    for kind, executor in executors.items():
        overhead = overheads[kind]
        plan = best_plan(len(genomes), executor.workers, known, overhead)
        work = known.seconds(len(genomes) // plan.chunks)
        beyond = overhead.task + overhead.latency / plan.chunks
        print_figure(
            f"  {kind}: overhead of a chunk, {plan.chunks} chunks",
            milliseconds(beyond),
            f"{100 * beyond / work:.2g} % of its work, {milliseconds(work)}",
        )


def print_gain(name: str, generation: int, rounds: int) -> None:
    """Print the time of one worker, the time of two workers, and the ideal time of two.

    For the ideal time, two workers each do all the work simultaneously, and the time is halved. The
    three take turns. The quickest times are those with the least disturbance by other programs, or
    by other users of the hardware below a virtual machine.
    """
    experiment = load_experiment(name)
    with Evaluator(experiment, 1) as one, Evaluator(experiment, WORKERS) as two:
        one.prepare()
        two.prepare()
        genomes = next(islice(evolve(experiment, two.evaluate), generation - 1, None)).genomes
        works = (
            lambda: one.evaluate(genomes),
            lambda: two.evaluate(genomes),
            lambda: two.map(processor_seconds, [genomes] * WORKERS),
        )
        for work in works:
            work()
        taken = np.array([[stopwatch(work) for work in works] for _ in range(rounds)])
    taken[:, 2] /= WORKERS
    print(f"{f'{name}, the population of generation {generation}':<52} {'median':>12}  quickest")
    for what, seconds in zip(("one worker", "two workers", "two, ideal"), taken.T, strict=True):
        typical = np.median(taken[:, 0] / seconds)
        least = taken[:, 0].min() / seconds.min()
        print_figure(
            f"  {what}",
            milliseconds(float(np.median(seconds))),
            f"{milliseconds(seconds.min())}  {typical:.2f} ×, {least:.2f} ×",
        )


def slow(genomes: Genomes) -> NDArray[np.float64]:
    """Return scores after 20 ms for each genome, asleep: other programs do not slow it down."""
    for _ in genomes:
        time.sleep(0.02)
    return -np.square(genomes).sum(axis=1)


def print_function(population: int, generations: int) -> None:
    """Print the time of a generation of a slow Python function with one worker and with two."""
    space = RealSpace(np.full(10, -5.0), np.full(10, 5.0))
    found = []
    for workers in (1, WORKERS):
        with gaitsim.evolve(
            body=slow,
            space=space,
            population=population,
            generations=generations,
            workers=workers,
        ) as search:
            seconds = [generation.seconds for generation in search]
        found.append(np.array(seconds[2:]))  # workers start in the first two
    one, two = found
    print(f"\na function that takes 20 ms, {population} individuals")
    print_figure("  one worker", milliseconds(float(np.median(one))))
    print_figure(
        "  two workers",
        milliseconds(float(np.median(two))),
        f"{np.median(one) / np.median(two):.2f} ×, {one.min() / two.min():.2f} ×",
    )


def print_idle(name: str, cluster: Executor) -> None:
    """Print the cost of a cluster that stays idle because sending work to it would be slower."""
    experiment = load_experiment(name)
    genomes = population(experiment)
    with Evaluator(experiment) as alone, Evaluator(experiment, cluster=cluster) as with_cluster:
        for evaluator in (alone, with_cluster):
            evaluator.prepare()
            evaluator.evaluate(genomes)
        without, beside = medians(
            lambda: alone.evaluate(genomes), lambda: with_cluster.evaluate(genomes), repeats=50
        )
    print_figure(f"{name}: without a cluster", milliseconds(without))
    print_figure(f"{name}: with an idle cluster", milliseconds(beside), times(beside / without))


def main() -> None:
    """Print the figures."""
    print_machine()
    with started_executors() as executors:
        overheads = {kind: measure_overhead(executor) for kind, executor in executors.items()}
        for kind, overhead in overheads.items():
            beside = f"and {milliseconds(overhead.latency)} per population"
            print_figure(f"{kind}: an empty task", milliseconds(overhead.task), beside)
        for name in ("walker", "spider-recurrence"):
            print_chunks(name, executors, overheads)
        print()
        print_gain("walker", 1, 30)
        print_gain("walker", 26, 10)
        print_function(10, 20)
        print_function(100, 8)
        if "Dask" in executors:
            print_idle("spider-recurrence", executors["Dask"])


if __name__ == "__main__":
    main()
