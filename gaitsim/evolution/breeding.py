"""One population from the one before: pure, and a function of seed and generation."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace
from gaitsim.errors import PluginError
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
    with containing(experiment.entries["organism"], "drawing genomes"):
        genomes = space.random(
            experiment.evolution.population, stream(experiment.seed, 1, Purpose.FIRST)
        )
    if not space.contains(genomes):
        entry = experiment.entries["organism"]
        raise PluginError(f"{entry} draws genomes outside its own space", where=entry.target)
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
    population = len(genomes)
    elites = experiment.evolution.elites
    wanted = population - elites
    entries = experiment.entries
    seed = experiment.seed
    with containing(entries["selection"], "selecting parents"):
        selection = experiment.selection.at(generation)
        crossover = experiment.crossover.at(generation)
        mutation = experiment.mutation.at(generation)
        pairs = -(-wanted // crossover.children)
        parents = selection.parents(scores, pairs, stream(seed, generation, Purpose.SELECTION))
        _hold(experiment, "selection", parents, (pairs, 2), np.dtype(np.intp))
        mothers, fathers = genomes[parents[:, 0]], genomes[parents[:, 1]]
    with containing(entries["crossover"], "crossing parents"):
        children = crossover.cross(
            mothers, fathers, space, stream(seed, generation, Purpose.CROSSOVER)
        )
        shape = (pairs * crossover.children, space.genes)
        _hold(experiment, "crossover", children, shape, space.dtype)
    with containing(entries["mutation"], "mutating children"):
        children = mutation.mutate(
            children[:wanted], space, stream(seed, generation, Purpose.MUTATION)
        )
        _hold(experiment, "mutation", children, (wanted, space.genes), space.dtype)
    with containing(entries["organism"], "confining genomes"):
        children = space.confine(children)
    # Stable, so that of equal scores the first stays first.
    best = np.argsort(-scores, kind="stable")[:elites]
    return np.concatenate([genomes[best], children])


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
    entry = experiment.entries[kind]
    raise PluginError(
        f"{entry} returned {came}",
        where=entry.target,
        allowed=f"an array of shape {shape}, dtype {dtype}",
        remedy=f"update {entry.package}, or report it to its author",
    )
