"""The time of the first generation compared with later ones, for bodies of known cost.

A body that moves whole arrays has a fixed cost per call, which each worker pays; a body that loops
takes the same time for each individual. Each line shows the medians of a few starts, and the range
of the ratio. The bodies consume processor time, so other programs slow them like real bodies.
"""

import argparse
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

import numpy as np
from timing import milliseconds, print_machine, stopwatch

from gaitsim.contracts import (
    Channel,
    Fitness,
    Genomes,
    GenomeSpace,
    Motion,
    Organism,
    RealSpace,
    Skeleton,
    option,
)
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.scoring import Scores
from gaitsim.evolution import evolve
from gaitsim.experiment import Experiment, parse_experiment

GENERATIONS = 4
PRESET = """
name = "costly"
evolution = {{ population = {population}, generations = 4 }}
organism = {{ plugin = "costly", fixed = {fixed}, each = {each} }}
fitness = {{ plugin = "costly-reach" }}
search = {{ plugin = "genetic" }}
selection = {{ plugin = "tournament" }}
crossover = {{ plugin = "uniform" }}
mutation = {{ plugin = "gaussian" }}
"""
PACKAGE = {
    "METADATA": "Metadata-Version: 2.1\nName: costly\nVersion: 0\n",
    "entry_points.txt": "[gaitsim.organism]\ncostly = first_generation:Costly\n"
    "[gaitsim.fitness]\ncostly-reach = first_generation:Reach\n",
}
# Seconds per call, seconds per individual, population, option --workers.
BODIES: tuple[tuple[float, float, int, int | None], ...] = (
    (0.009, 2e-6, 2000, 2),
    (0.05, 1e-5, 2000, None),
    (0.3, 6e-5, 100, 2),
    (0.3, 6e-5, 2000, None),
    (1.5, 3e-4, 100, 2),
    (0.0, 0.02, 200, 2),
    (0.3, 0.02, 100, 2),
)


class Costly(Organism):
    """A body that consumes a given processor time."""

    fixed: float = option(0.0, "fixed cost per call", unit="s", ge=0)
    each: float = option(0.0, "cost per individual", unit="s", ge=0)

    channels: ClassVar[Mapping[str, Channel]] = {"reach": Channel((), "m", "distance reached")}

    def genome_space(self) -> GenomeSpace:
        """Return two genes."""
        return RealSpace(np.full(2, -1.0), np.full(2, 1.0), ("a", "b"))

    def move(self, genomes: Genomes) -> Motion:
        """Consume the processor time, and return the motion."""
        end = time.thread_time() + self.fixed + len(genomes) * self.each
        while time.thread_time() < end:
            pass
        return Motion(1.0, {"reach": genomes.sum(axis=1)})

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return a skeleton of one point."""
        return Skeleton(np.zeros((1, 1, 2, 3)), ("a",), motion.frame_rate)

    def joint_names(self) -> tuple[str, ...]:
        """Return no names."""
        return ()


class Reach(Fitness):
    """The distance reached."""

    needs: ClassVar[tuple[str, ...]] = ("reach",)

    def terms(self, motion: Motion) -> dict[str, Scores]:
        """Return the reach."""
        return {"reach": motion["reach"]}


@contextmanager
def registered_plugins() -> Iterator[None]:
    """Register both plugins in this process and its worker processes."""
    with TemporaryDirectory() as folder:
        metadata = Path(folder) / "costly-0.dist-info"
        metadata.mkdir()
        for name, text in PACKAGE.items():
            (metadata / name).write_text(text)
        sys.path.insert(0, folder)
        yield


def generations(experiment: Experiment, workers: int | None) -> list[float]:
    """Return the seconds of the preparation and of each generation."""
    with Evaluator(experiment, workers) as evaluator:
        taken = [stopwatch(evaluator.prepare)]
        evolved = evolve(experiment, evaluator.evaluate)
        return taken + [stopwatch(lambda: next(evolved)) for _ in range(GENERATIONS)]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=5, help="starts per line; default: 5")
    repeats = parser.parse_args().repeats
    print_machine()
    names = "population", "--workers", "before", "first", "later", "ratio"
    print(f"{'per call + individual':<26}" + "".join(f"{name:>12}" for name in names))
    with registered_plugins():
        for fixed, each, population, workers in BODIES:
            text = PRESET.format(fixed=fixed, each=each, population=population)
            experiment = parse_experiment(text, "the benchmark")
            starts = np.array([generations(experiment, workers) for _ in range(repeats)])
            before, first = np.median(starts[:, :2], axis=0)
            later = np.median(starts[:, 2:], axis=1)
            ratios = starts[:, 1] / later
            seconds = (milliseconds(float(one)) for one in (before, first, np.median(later)))
            print(
                f"{f'{milliseconds(fixed)} + {milliseconds(each)}':<26}"
                + "".join(f"{one:>12}" for one in (population, workers or "", *seconds))
                + f"{np.median(ratios):>12.2f}  {ratios.min():.2f} to {ratios.max():.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
