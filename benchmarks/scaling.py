"""A generation on clusters of growing size, simulated from what was measured on this machine.

A scheduler hands out tasks one after the other; a worker that is done gets the next one.
The times of individuals vary, as a walker that falls is done sooner. Nothing is guessed
but the cluster's size: work, its variation, and what a task and its way cost are measured,
the way by Dask workers of this machine; a network adds its round trip, an option.

    python benchmarks/scaling.py [--task MS --latency MS] [--round-trip MS]
"""

import argparse
import heapq
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from processor import processor_seconds
from timing import milliseconds, print_machine, stopwatch

from gaitsim.evaluation import evaluate
from gaitsim.evaluation.chunking import CostModel, Overhead, best_plan, cuts, measure_overhead
from gaitsim.evolution import first_population
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.writer import RunWriter

SIZES = (1, 2, 8, 32, 100, 316, 1000, 3162, 10_000)
STRETCH = 10  # generations between two migrations
ISLAND = 100  # individuals


def individual_seconds(experiment: Experiment, count: int = 60) -> NDArray[np.float64]:
    """How long individuals of an initial population take, each alone, CPU seconds."""
    genomes = first_population(experiment)[:count]
    evaluate(experiment, genomes[:1])
    return np.array(
        [processor_seconds(experiment, genomes[at : at + 1]) for at in range(len(genomes))]
    )


def recording_seconds(population: int) -> float:
    """What a generation of so many walkers takes to be bred and recorded, evaluation left out."""
    experiment = load_experiment(
        "walker", {"evolution.population": population, "evolution.generations": 3}
    )
    evaluation = evaluate(experiment, first_population(experiment)[:1])

    def score(genomes: NDArray[np.float64]) -> object:
        many = len(genomes)
        scores = np.linspace(0, 1, many)
        return type(evaluation)(scores, dict.fromkeys(evaluation.terms, scores), {})

    with (
        tempfile.TemporaryDirectory() as folder,
        RunWriter.open(create_run(experiment, Path(folder) / "run")) as writer,
    ):
        taken = stopwatch(lambda: [*writer.evolve(score)])  # type: ignore[arg-type]
    return taken / 3


def simulated(tasks: NDArray[np.float64], workers: int, overhead: Overhead) -> float:
    """Seconds until the last of the tasks is back."""
    free = [0.0] * min(workers, len(tasks))  # when each worker is free again
    sent, end = 0.0, 0.0
    for seconds in tasks.tolist():
        sent = max(sent + overhead.task, heapq.heappop(free))
        heapq.heappush(free, sent + seconds)
        end = max(end, sent + seconds)
    return end + overhead.latency


def one_population(each: NDArray[np.float64], size: int, workers: int, overhead: Overhead) -> float:
    """Seconds of a generation of one population, cut as gaitsim would."""
    if workers == 1:
        return float(each.mean() * size)
    cost_model = CostModel()
    cost_model.learn(1, float(each.mean()))
    cost_model.learn(size, float(each.mean() * size))
    chunks = best_plan(size, workers, cost_model, overhead).chunks
    drawn = np.random.default_rng(0).choice(each, size)
    parts = np.split(drawn, cuts(size, chunks, workers))
    return simulated(np.array([part.sum() for part in parts]), workers, overhead)


def islands(each: NDArray[np.float64], workers: int, overhead: Overhead) -> float:
    """Seconds a generation of as many islands as workers, each task one epoch."""
    drawn = np.random.default_rng(0).choice(each, (workers, STRETCH * ISLAND)).sum(axis=1)
    return simulated(drawn, workers, overhead) / STRETCH


def measure_dask() -> Overhead:
    """Of two Dask workers on this machine."""
    from gaitsim.evaluation.dask import DaskExecutor

    with DaskExecutor("local", 2) as cluster:
        return measure_overhead(cluster)


def main() -> None:
    """Print the curves."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", type=float, help="a task's cost in ms, instead of measuring")
    parser.add_argument("--latency", type=float, default=0.0, help="of a population, ms")
    parser.add_argument("--round-trip", type=float, default=0.0, help="of the network, ms")
    given = parser.parse_args()
    print_machine()
    overhead = Overhead(given.latency / 1e3, given.task / 1e3) if given.task else measure_dask()
    overhead = Overhead(overhead.latency + given.round_trip / 1e3, overhead.task)
    each = individual_seconds(load_experiment("walker"))
    mean, spread = each.mean(), each.std() / each.mean()
    print(f"an individual of the walker: {milliseconds(mean)}, varying by {spread:.0%}")
    print(
        f"a task: {milliseconds(overhead.task)}; a population: {milliseconds(overhead.latency)}\n"
    )
    print(f"{'workers':>8} {'100':>16} {'10,000':>16} {'1,000,000':>16}   an island of 100 each")
    for workers in SIZES:
        cells = []
        for size in (100, 10_000, 1_000_000):
            seconds = one_population(each, size, workers, overhead)
            gain = mean * size / seconds
            cells.append(f"{gain:>8.1f} × {gain / workers:>4.0%}")
        seconds = islands(each, workers, overhead)
        gain = mean * ISLAND * workers / seconds
        print(f"{workers:>8,} {' '.join(f'{cell:>16}' for cell in cells)}", end="   ")
        print(f"{gain:>8.1f} × {gain / workers:>4.0%}")
    print("\nspeed-up over one worker, and its part of what so many could do\n")
    for size in (100, 10_000, 1_000_000):
        print(f"breeding and recording {size:,} walkers: {milliseconds(recording_seconds(size))}")


if __name__ == "__main__":
    main()
