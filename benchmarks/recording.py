"""The time to record a generation of spider-genetic, and to save gathered generations."""

import os
import statistics
import tempfile
import time
from functools import partial
from pathlib import Path

from timing import milliseconds, print_budget, print_figure, print_machine

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.storage import writer as writing
from gaitsim.storage.creation import create_run

BUDGET = 0.0005  # seconds per generation, without a save
RUNS, GENERATIONS, TOGETHER = 10, 40, 20


class CountedSync:
    """Replacement for `os.fsync` that measures its total time."""

    def __init__(self) -> None:
        self._sync, self.calls, self.seconds = os.fsync, 0, 0.0

    def __call__(self, descriptor: int) -> None:
        """Force a file to disk."""
        start = time.perf_counter()
        self._sync(descriptor)
        self.seconds += time.perf_counter() - start
        self.calls += 1


def main() -> None:
    """Print the figures."""
    print_machine()
    options = {"evolution.generations": GENERATIONS, "evolution.fitness_threshold": "none"}
    experiment = load_experiment("spider-genetic", options)
    generations = list(evolve(experiment, partial(evaluate, experiment)))
    sync = os.fsync = CountedSync()
    writing.PERIOD = 1e9  # saved by this script
    recording, saving, forced = [], [], []
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        for run in range(RUNS):
            path = create_run(experiment, Path(folder) / str(run))
            with writing.RunWriter.open(path) as writer:
                writer.record(generations[0])  # saved at once
                for generation in generations[1:-1]:
                    start = time.perf_counter()
                    writer.record(generation)
                    recording.append(time.perf_counter() - start)
                    if generation.number % TOGETHER == 0:
                        before, start = sync.seconds, time.perf_counter()
                        writer.save()
                        forced.append(sync.seconds - before)
                        saving.append(time.perf_counter() - start - forced[-1])
    seconds = statistics.median(recording)
    print_budget("recording a generation", seconds, BUDGET, milliseconds)
    print_figure(
        f"saving {TOGETHER} generations, at most every half second",
        milliseconds(statistics.median(saving)),
        f"excluding fsync, {milliseconds(statistics.median(forced))}",
    )


if __name__ == "__main__":
    main()
