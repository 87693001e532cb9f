"""A generation on clusters of growing size, simulated from measurements on this machine.

A scheduler assigns tasks one at a time; an idle worker gets the next task. The times of individuals
vary, as the simulation of a walker ends when it falls. Only the size of the cluster is assumed. The
times of individuals and the overhead of a task are measured, the overhead with Dask workers on this
machine. `--round-trip` adds the latency of a network.

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
from gaitsim.evaluation.chunking import (
    CostModel,
    Overhead,
    best_plan,
    measure_overhead,
    split_indices,
)
from gaitsim.evolution import first_population
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter

SIZES = (1, 2, 8, 32, 100, 316, 1000, 3162, 10_000)
EPOCH = 10  # generations between two migrations
ISLAND_SIZE = 100  # individuals


def individual_seconds(experiment: Experiment, count: int = 60) -> NDArray[np.float64]:
    """Return the CPU seconds of each individual of an initial population, evaluated alone."""
    genomes = first_population(experiment)[:count]
    evaluate(experiment, genomes[:1])
    return np.array(
        [processor_seconds(experiment, genomes[at : at + 1]) for at in range(len(genomes))]
    )


def recording_seconds(population: int) -> float:
    """Return the seconds to breed and record a generation of walkers, without evaluation."""
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


def simulate_schedule(tasks: NDArray[np.float64], workers: int, overhead: Overhead) -> float:
    """Return the seconds until the last result of a list of tasks, seconds each, arrives."""
    free = [0.0] * min(workers, len(tasks))  # time at which each worker becomes idle
    sent, end = 0.0, 0.0
    for seconds in tasks.tolist():
        sent = max(sent + overhead.task, heapq.heappop(free))
        heapq.heappush(free, sent + seconds)
        end = max(end, sent + seconds)
    return end + overhead.latency


def population_generation(
    each: NDArray[np.float64], size: int, workers: int, overhead: Overhead
) -> float:
    """Return the seconds of a generation of one population, in chunks as gaitsim chooses them."""
    if workers == 1:
        return float(each.mean() * size)
    cost_model = CostModel()
    cost_model.learn(1, float(each.mean()))
    cost_model.learn(size, float(each.mean() * size))
    chunks = best_plan(size, workers, cost_model, overhead).chunks
    drawn = np.random.default_rng(0).choice(each, size)
    parts = np.split(drawn, split_indices(size, chunks, workers))
    return simulate_schedule(np.array([part.sum() for part in parts]), workers, overhead)


def islands_generation(each: NDArray[np.float64], workers: int, overhead: Overhead) -> float:
    """Return the seconds of a generation with one island per worker; a task is an epoch."""
    drawn = np.random.default_rng(0).choice(each, (workers, EPOCH * ISLAND_SIZE)).sum(axis=1)
    return simulate_schedule(drawn, workers, overhead) / EPOCH


def measure_dask() -> Overhead:
    """Return the overhead of two Dask workers on this machine."""
    from gaitsim.evaluation.dask import DaskExecutor

    with DaskExecutor("local", 2) as cluster:
        return measure_overhead(cluster)


def main() -> None:
    """Print the curves."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", type=float, help="overhead of a task, ms; default: measured")
    parser.add_argument(
        "--latency", type=float, default=0.0, help="overhead of a population, ms; used with --task"
    )
    parser.add_argument(
        "--round-trip", type=float, default=0.0, help="round trip of the network, ms"
    )
    given = parser.parse_args()
    print_machine()
    overhead = Overhead(given.latency / 1e3, given.task / 1e3) if given.task else measure_dask()
    overhead = Overhead(overhead.latency + given.round_trip / 1e3, overhead.task)
    each = individual_seconds(load_experiment("walker"))
    mean, spread = each.mean(), each.std() / each.mean()
    print(f"an individual of the walker: {milliseconds(mean)}, standard deviation {spread:.0%}")
    print(
        f"a task: {milliseconds(overhead.task)}; a population: {milliseconds(overhead.latency)}\n"
    )
    print(f"{'workers':>8} {'100':>16} {'10,000':>16} {'1,000,000':>16}   islands of 100")
    for workers in SIZES:
        cells = []
        for size in (100, 10_000, 1_000_000):
            seconds = population_generation(each, size, workers, overhead)
            gain = mean * size / seconds
            cells.append(f"{gain:>8.1f} × {gain / workers:>4.0%}")
        seconds = islands_generation(each, workers, overhead)
        gain = mean * ISLAND_SIZE * workers / seconds
        print(f"{workers:>8,} {' '.join(f'{cell:>16}' for cell in cells)}", end="   ")
        print(f"{gain:>8.1f} × {gain / workers:>4.0%}")
    print("\nspeed-up over one worker, and its share of the ideal speed-up\n")
    for size in (100, 10_000, 1_000_000):
        print(f"breeding and recording {size:,} walkers: {milliseconds(recording_seconds(size))}")


if __name__ == "__main__":
    main()
