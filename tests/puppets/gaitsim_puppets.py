"""A package of plugins in plain Python, as a third party's: cheap, and to be spoilt by tests."""

import time
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import model_validator

from gaitsim.plugin import (
    WORLD_HELP,
    BitSpace,
    Channel,
    Condition,
    Crossover,
    Fitness,
    Measure,
    Motion,
    Mutation,
    Organism,
    RealSpace,
    Selection,
    Skeleton,
    check_world,
    option,
)

FRAMES = 5


class Puppet(Organism):
    """Three joints that turn to the angles that the genes say."""

    pause: float = option(0.0, "how long several think before they move", unit="s", ge=0)

    load: float = option(0.0, "weight that reduces the reach of the first joint", unit="kg", ge=0)

    threads: ClassVar[bool] = False
    channels: ClassVar[Mapping[str, Channel]] = {
        "joint_angles": Channel(("frames", "joints"), "rad", "angles"),
        "reach": Channel((), "m", "how far it reaches"),
    }

    def genome_space(self):
        return RealSpace(np.full(3, -1.0), np.full(3, 2.0), ("a", "b", "c"))

    def move(self, genomes):
        if len(genomes) > 1:  # not when one is moved to prepare, or to be shown
            time.sleep(self.pause)
        steps = np.linspace(0, 1, FRAMES)[:, None]
        return Motion(
            4.0,
            {"joint_angles": genomes[:, None] * steps},
            {("reach",): lambda: {"reach": self._reach(genomes)}},
        )

    def _reach(self, genomes):
        reach = np.sin(genomes).sum(axis=1)
        return reach - self.load * np.abs(genomes[:, 0]) if self.load else reach

    def skeleton(self, motion, individual):
        return Skeleton(np.zeros((FRAMES, 3, 2, 3)), ("a", "b", "c"), motion.frame_rate)

    def measures(self, motion):
        return {"reach": Measure(motion["reach"], "m", "how far it reaches")}

    def joint_names(self):
        return ("shoulder", "elbow", "wrist")


class WindyPuppet(Puppet):
    """A puppet whose reach depends on the wind."""

    world: dict[str, float] = option({}, WORLD_HELP)

    def conditions(self):
        return {"wind": Condition("m/s", 0.0, -0.5, 0.5, -9.0, 9.0, "turns all joints")}

    def checks(self):
        return ({"wind": 0.1}, {"wind": 9.0})

    @model_validator(mode="after")
    def _check(self):
        check_world(self.world, self.conditions())
        return self

    def move(self, genomes):
        motion, wind = super().move(genomes), self.world.get("wind", 0.0)
        reach = np.sin(genomes + wind).sum(axis=1)
        lost = np.flatnonzero(genomes[:, 0] + wind > 2.2)
        return Motion(
            motion.frame_rate,
            {"joint_angles": motion["joint_angles"], "reach": reach},
            failures={int(one): "it is blown away" for one in lost},
        )


class BitPuppet(Puppet):
    """A puppet whose joints are turned or not."""

    def genome_space(self):
        return BitSpace(("a", "b", "c"))

    def move(self, genomes):
        return super().move(genomes.astype(float))


class Reach(Fitness):
    """Reward reach, and penalise each turned joint."""

    price: float = option(0.1, "of a turned joint", unit="m/rad", ge=0)

    needs: ClassVar[tuple[str, ...]] = ("joint_angles", "reach")

    def terms(self, motion):
        turned = np.abs(motion["joint_angles"][:, -1]).sum(axis=1)
        return {"reach": motion["reach"], "price": -self.price * turned}


class Best(Selection):
    """The best one is everybody's mother."""

    def parents(self, scores, pairs, rng):
        fathers = rng.integers(len(scores), size=pairs, dtype=np.intp)
        return np.stack([np.full(pairs, np.argmax(scores), dtype=np.intp), fathers], axis=1)


class Mean(Crossover):
    """Half of each; for bits the mother's."""

    def cross(self, mothers, fathers, space, rng):
        child = (mothers + fathers) / 2 if space.dtype.kind == "f" else mothers.copy()
        return np.concatenate([child] * self.children)


class Jitter(Mutation):
    """A little noise; for bits now and then another one."""

    def mutate(self, genomes, space, rng):
        if space.dtype.kind == "f":
            return genomes + rng.normal(0, 0.3, genomes.shape)
        return genomes ^ (rng.random(genomes.shape) < 0.1).astype(np.uint8)
