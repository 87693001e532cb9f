"""A cheap body with dimensions, whose best design is known, and a map of its designs."""

import pytest
from tui_driver import config, drive, state_folder  # noqa: F401 (fixtures)

CRAWLER = """
from typing import ClassVar
import numpy as np
from gaitsim.plugin import (
    Channel, Dimension, Fitness, Measure, Motion, Organism, RealSpace, Skeleton, check_dimensions,
    factor_bounds, option,
)

class Crawler(Organism):
    "Its best arm is 1.2 times as long, its best leg 0.85 times; its tail does not matter."
    dimensions: dict[str, float] = option({}, "factors")
    evolve: tuple[str, ...] = option((), "dimensions that are genes")
    ranges: dict[str, tuple[float, float]] = option({}, "their ranges")
    channels: ClassVar = {"speed": Channel((), "m/s", "speed"), "work": Channel((), "J", "work")}

    def design_space(self):
        sizes = {"arm": 0.1, "leg": 0.2, "tail": 0.3}
        return {name: Dimension("m", size, name) for name, size in sizes.items()}

    def genome_space(self):
        check_dimensions(self.design_space(), self.dimensions, self.evolve, self.ranges)
        low, high = factor_bounds(self.design_space(), self.evolve, self.ranges)
        labels = ("swing", "push", *self.evolve)
        return RealSpace(np.append([-1.0, -1.0], low), np.append([1.0, 1.0], high), labels)

    def embody(self, genome):
        return self, genome

    def move(self, genomes):
        factors = {name: np.ones(len(genomes)) for name in self.design_space()}
        factors |= dict(zip(self.evolve, genomes[:, 2:].T))
        gait = np.square(genomes[:, 0] - 0.4) + np.square(genomes[:, 1] - 0.2 * factors["arm"])
        shape = np.square(factors["arm"] - 1.2) + np.square(factors["leg"] - 0.85)
        speed = 2 - gait - 4 * shape
        failed = np.flatnonzero(factors["leg"] > 1.29).tolist()
        data = {"speed": speed, "work": 1 + factors["leg"]}
        return Motion(10.0, data, failures={one: "its leg is too long" for one in failed})

    def measures(self, motion):
        return {
            "speed": Measure(motion["speed"], "m/s", "speed"),
            "cost of transport": Measure(motion["work"] / motion["speed"], "", "work per way"),
        }

    def skeleton(self, motion, individual):
        ends = np.zeros((4, 1, 2, 3))
        ends[..., 1, 0] = 1 + np.arange(4)[:, None] * motion["speed"][individual]
        return Skeleton(ends, ("body",), 10.0)

class Far(Fitness):
    "The speed."
    needs: ClassVar = ("speed",)
    unit: ClassVar = "m/s"
    def terms(self, motion):
        return {"speed": motion["speed"]}
"""
EXPERIMENT = """
name = "crawler"
seed = 3
[evolution]
population = 8
generations = 5
[organism]
plugin = "crawler"
[fitness]
plugin = "far"
[search]
plugin = "cma-es"
"""
SHORT = "--levels", 7, "--original", 6, "--polish", 8


@pytest.fixture
def crawler(install, tmp_path, puppets):
    """The path of an experiment of a body with three dimensions."""
    install("crawlers", CRAWLER, {"organism": {"crawler": "Crawler"}, "fitness": {"far": "Far"}})
    path = tmp_path / "crawler.toml"
    path.write_text(EXPERIMENT)
    return path


@pytest.fixture
def mapped(crawler, gaitsim, tmp_path, once):
    """The folder of a finished map of 49 designs in three replicates."""
    folder = tmp_path / "runs/crawler-designs"
    return once("designs", folder, lambda: gaitsim("design", crawler, *SHORT))
