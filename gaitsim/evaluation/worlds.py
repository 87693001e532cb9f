"""The worlds in which individuals are evaluated: values of conditions, drawn from the seed."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from pydantic import ValidationError

from gaitsim.contracts import Condition, Organism
from gaitsim.contracts.conditions import SEED
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.experiment import NO_REALITY, OWN_WORLD, WORLD, Experiment
from gaitsim.registry import plugin_errors

World = Mapping[str, float]
"""Values of conditions by name, and the `seed` of the world's random choices."""

Ranges = Mapping[str, tuple[float, float]]


def has_worlds(experiment: Experiment) -> bool:
    """Return whether the body has conditions that vary between worlds."""
    return WORLD in type(experiment.organism).model_fields


def default_conditions(model: type[Organism]) -> Mapping[str, Condition]:
    """Return the conditions of a body with its default options; {} if it needs other options."""
    if WORLD not in model.model_fields:
        return {}
    try:
        return model().conditions()
    except (ValidationError, GaitsimError):
        return {}


def conditions_of(experiment: Experiment) -> Mapping[str, Condition]:
    """Return the conditions of the body that vary between worlds, by name."""
    entry = experiment.entries["organism"]
    with plugin_errors(entry, "naming its conditions"):
        found = experiment.organism.conditions() if has_worlds(experiment) else {}
    if not found:
        raise GaitsimError(
            f"the body {entry.name!r} has no conditions that vary between worlds",
            where=experiment.name,
            allowed="a body with conditions, such as the walker",
        )
    return found


def ranges_of(experiment: Experiment) -> dict[str, tuple[float, float]]:
    """Return the range of each condition that varies between the experiment's worlds, by name."""
    if experiment.worlds.ranges:
        return dict(experiment.worlds.ranges)
    conditions = conditions_of(experiment)
    return {name: (one.low, one.high) for name, one in conditions.items() if one.drawn}


def draw_worlds(experiment: Experiment, generation: int) -> tuple[World, ...]:
    """Return the worlds of a generation, counted from 1: the cases, then the drawn worlds."""
    worlds = experiment.worlds
    if not worlds.number:
        return worlds.cases
    rng = stream(experiment.seed, worlds.draw(generation), Purpose.WORLDS)
    return *worlds.cases, *_sample(ranges_of(experiment), worlds.number, rng)


def draw_unseen_worlds(
    experiment: Experiment, number: int, ranges: Ranges | None = None, seed: int = 0
) -> tuple[World, ...]:
    """Draw worlds in which no generation was evaluated.

    Args:
        experiment: experiment with the body.
        number: number of worlds.
        ranges: range of each condition that varies; None for the ranges of the experiment.
        seed: seed of the worlds. It is independent of the experiment's seed, so that all runs are
            tested in the same worlds.
    """
    rng = stream(seed, 0, Purpose.UNSEEN_WORLDS)
    return _sample(ranges_of(experiment) if ranges is None else ranges, number, rng)


def _sample(ranges: Ranges, number: int, rng: np.random.Generator) -> tuple[World, ...]:
    """Draw worlds by Latin hypercube sampling.

    Source: McKay, Beckman and Conover 1979, "A comparison of three methods for selecting values of
    input variables in the analysis of output from a computer code".
    """
    values = {
        name: low + (high - low) * (rng.permutation(number) + rng.random(number)) / number
        for name, (low, high) in sorted(ranges.items())
    }
    seeds = rng.integers(2**32, size=number)
    return tuple(
        {**{name: float(found[at]) for name, found in values.items()}, SEED: float(seeds[at])}
        for at in range(number)
    )


def in_world(experiment: Experiment, world: World) -> Experiment:
    """Return the experiment with its body in a world, whose values must be within their bounds."""
    organism = experiment.organism
    values = {**getattr(organism, WORLD), **world}
    moved = organism.model_copy(update={WORLD: values})
    return replace(experiment, organism=moved, worlds=OWN_WORLD)


def in_reality(experiment: Experiment) -> Experiment:
    """Return the experiment with the body that represents reality."""
    if experiment.reality is None:
        raise ValueError("the experiment has no body that represents reality")
    return replace(
        experiment,
        organism=experiment.reality,
        reality=None,
        transferability=NO_REALITY,
        worlds=OWN_WORLD,
    )


def describe(world: World) -> str:
    """Return a world in words, such as 'friction 0.4, slope 2, seed 17'."""
    return ", ".join(
        f"{name} {value:.0f}" if name == SEED else f"{name} {value:.4g}"
        for name, value in world.items()
    )


def parse_world(texts: Iterable[str], where: str = "") -> World:
    """Parse a world from texts as `describe` writes them, each with one or more conditions."""
    world: dict[str, float] = {}
    for text in (one.strip() for part in texts for one in part.split(",")):
        try:
            name, value = text.replace("=", " ").split()
            found = float(value)
            if name in world or not math.isfinite(found):
                raise ValueError
        except ValueError:
            raise GaitsimError(
                f"invalid condition of a world: {text!r}",
                where=where,
                allowed="a name and a number, such as 'friction 0.4'; each condition at most once",
            ) from None
        world[name] = found
    return world
