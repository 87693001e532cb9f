"""One population from the one before: pure, and a function of seed and generation."""

from enum import IntEnum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import BitSpace, Genomes, GenomeSpace, Plugin
from gaitsim.evaluation.judge import broken
from gaitsim.experiment import Experiment
from gaitsim.registry import containing


class Purpose(IntEnum):
    """What a random stream is for. The numbers are part of what makes a run repeatable."""

    FIRST = 0
    SELECTION = 1
    CROSSOVER = 2
    MUTATION = 3


def stream(seed: int, generation: int, purpose: Purpose) -> np.random.Generator:
    """The random stream of one purpose in one generation. There is no state to save."""
    return np.random.default_rng([seed, generation, purpose])


def first_population(experiment: Experiment, space: GenomeSpace) -> Genomes:
    """Generation 1: fresh genomes, (population, genes)."""
    population = experiment.evolution.population
    with containing(experiment.entries["organism"], "drawing genomes"):
        genomes = space.random(population, stream(experiment.seed, 1, Purpose.FIRST))
        belongs = space.contains(genomes) and len(genomes) == population
    if not belongs:
        raise broken(experiment, "organism", "draws genomes that are not of its own space")
    return genomes


def breed(
    experiment: Experiment,
    space: GenomeSpace,
    genomes: Genomes,
    scores: NDArray[np.float64],
    generation: int,
) -> Genomes:
    """The population of `generation` from the one before.

    Elites are copied; parents are selected, crossed, and their children mutated, then
    confined to the space. Children beyond the population's size are dropped.

    Args:
        experiment: its scheme and seed.
        space: the genome space.
        genomes: the population before, (population, genes); not changed.
        scores: (population,), more is better.
        generation: number of the generation that is made, from 2.

    Returns:
        (population, genes): the elites, best first, then the children.

    Raises:
        PluginError: an operator fails or breaks its contract; names its package.
    """
    elites = experiment.evolution.elites
    wanted = len(genomes) - elites
    # Stable, so that of equal scores the first stays first.
    best = np.argsort(-scores, kind="stable")[:elites]
    selection = _at(experiment, "selection", experiment.selection, generation)
    crossover = _at(experiment, "crossover", experiment.crossover, generation)
    mutation = _at(experiment, "mutation", experiment.mutation, generation)
    pairs = -(-wanted // crossover.children)
    # Each operator gets arrays of its own: what it changes in them is seen by no other.
    with containing(experiment.entries["selection"], "selecting parents"):
        parents = selection.parents(
            scores.copy(), pairs, stream(experiment.seed, generation, Purpose.SELECTION)
        )
    _hold_parents(experiment, parents, pairs, len(genomes))
    with containing(experiment.entries["crossover"], "crossing parents"):
        children = crossover.cross(
            genomes[parents[:, 0]],
            genomes[parents[:, 1]],
            space,
            stream(experiment.seed, generation, Purpose.CROSSOVER),
        )
    _hold_children(experiment, "crossover", children, pairs * crossover.children, space)
    with containing(experiment.entries["mutation"], "mutating children"):
        children = mutation.mutate(
            children[:wanted], space, stream(experiment.seed, generation, Purpose.MUTATION)
        )
    _hold_children(experiment, "mutation", children, wanted, space)
    with containing(experiment.entries["organism"], "confining genomes"):
        children = space.confine(children)
        belong = space.contains(children) and len(children) == wanted
    if not belong:
        raise broken(experiment, "organism", "confines genomes to ones that are not of its space")
    return np.concatenate([genomes[best], children])


_Scheduled = TypeVar("_Scheduled", bound=Plugin)


def _at(experiment: Experiment, kind: str, plugin: _Scheduled, generation: int) -> _Scheduled:
    """The plugin with its options as they are at this generation."""
    with containing(experiment.entries[kind], "following its schedule"):
        return plugin.at(generation)


def _hold_parents(
    experiment: Experiment, parents: NDArray[np.intp], pairs: int, population: int
) -> None:
    """Hold selection to indices of the population."""
    _hold(experiment, "selection", parents, (pairs, 2), np.dtype(np.intp))
    if not ((parents >= 0) & (parents < population)).all():
        raise broken(
            experiment,
            "selection",
            f"chose the parents {parents.min()} to {parents.max()}",
            f"indices from 0 to {population - 1}",
        )


def _hold_children(
    experiment: Experiment, kind: str, children: Genomes, count: int, space: GenomeSpace
) -> None:
    """Hold crossover and mutation to genomes that confining can bring into the space."""
    _hold(experiment, kind, children, (count, space.genes), space.dtype)
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        raise broken(experiment, kind, "returned genes that are not finite", "finite genes")
    if isinstance(space, BitSpace) and not (children <= 1).all():
        raise broken(experiment, kind, "returned genes that are no bits", "0 and 1")


def _hold(
    experiment: Experiment,
    kind: str,
    result: object,
    shape: tuple[int, ...],
    dtype: np.dtype[np.generic],
) -> None:
    """Hold an operator to the shape and dtype that its contract promises."""
    if isinstance(result, np.ndarray) and result.shape == shape and result.dtype == dtype:
        return
    came = (
        f"shape {result.shape}, dtype {result.dtype}"
        if isinstance(result, np.ndarray)
        else type(result).__name__
    )
    raise broken(experiment, kind, f"returned {came}", f"an array of shape {shape}, dtype {dtype}")
