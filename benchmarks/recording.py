"""The time to record a generation of the default spider, excluding `fsync`."""

import os
import statistics
import tempfile
import time
from functools import partial
from pathlib import Path

from timing import milliseconds, print_figure, print_machine

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.writer import RunWriter

BUDGET = 0.0005  # seconds per generation without a champion
RUNS, GENERATIONS = 10, 40


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
    experiment = load_experiment("spider", {"evolution.generations": GENERATIONS})
    generations = list(evolve(experiment, partial(evaluate, experiment)))
    sync = os.fsync = CountedSync()
    taken: dict[bool, list[tuple[float, float, int]]] = {True: [], False: []}
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        for run in range(RUNS):
            with RunWriter.open(create_run(experiment, Path(folder) / str(run))) as writer:
                for generation in generations:
                    forced, calls, start = sync.seconds, sync.calls, time.perf_counter()
                    writer.record(generation)
                    seconds, forced = time.perf_counter() - start, sync.seconds - forced
                    taken[generation.is_champion].append(
                        (seconds - forced, forced, sync.calls - calls)
                    )
    for is_champion, every in taken.items():
        own, forced, calls = map(statistics.median, zip(*every, strict=True))
        print_figure(
            "a generation with a champion" if is_champion else "a generation",
            milliseconds(own),
            f"excluding {calls:g} calls of fsync, {milliseconds(forced)}"
            + ("" if is_champion else f"; budget {milliseconds(BUDGET)}"),
        )


if __name__ == "__main__":
    main()
