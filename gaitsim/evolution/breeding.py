"""Breeding: one population from the one before, a pure function of seed and generation."""

from enum import IntEnum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, BitSpace, Genomes, GenomeSpace, Plugin, Selection
from gaitsim.experiment import Experiment
from gaitsim.registry import contract_error, plugin_errors


class Purpose(IntEnum):
    """Purpose of a random stream. Other numbers would change the results of every run."""

    INITIAL = 0
    SELECTION = 1
    CROSSOVER = 2
    MUTATION = 3


def stream(seed: int, generation: int, purpose: Purpose, island: int = 0) -> np.random.Generator:
    """Return the random stream of one purpose in one generation, so that no state is saved.

    Each island has streams of its own; the first one has those of a search without islands.
    """
    return np.random.default_rng([seed, generation, purpose, *([island] if island else [])])


def initial_population(experiment: Experiment, space: GenomeSpace, island: int = 0) -> Genomes:
    """Draw generation 1, (population, genes)."""
    only: Genomes = initial_populations(experiment, space, 1, island)[0]
    return only


def initial_populations(
    experiment: Experiment, space: GenomeSpace, populations: int, island: int = 0
) -> Genomes:
    """Draw generation 1 of several populations, (populations, population, genes)."""
    size = experiment.evolution.population
    rng = stream(experiment.seed, 1, Purpose.INITIAL, island)
    with plugin_errors(experiment.entries["organism"], "drawing genomes"):
        genomes = space.random(populations * size, rng)
        belongs = space.contains(genomes) and len(genomes) == populations * size
    if not belongs:
        raise contract_error(
            experiment.entries["organism"], "draws genomes that are not of its own space"
        )
    return genomes.reshape(populations, size, space.genes)


def warm_start_population(
    experiment: Experiment, space: GenomeSpace, start: Array, island: int = 0
) -> Genomes:
    """Return generation 1 of a warm start: one genome, then mutations of it.

    They come from the experiment's mutation with its options at generation 1, and from that
    generation's random stream of mutation.

    Args:
        experiment: its scheme and seed.
        space: the genome space.
        start: genome of the space, (genes,).
        island: number of the island.

    Returns:
        (population, genes), the genome itself first.

    Raises:
        PluginError: the mutation fails or breaks its contract; names its package.
    """
    copies = np.tile(start, (experiment.evolution.population - 1, 1))
    mutants = _mutated(experiment, space, copies, 1, island)
    return np.concatenate([start[None], mutants])


def breed(
    experiment: Experiment,
    space: GenomeSpace,
    genomes: Genomes,
    scores: NDArray[np.float64],
    generation: int,
    island: int = 0,
) -> Genomes:
    """Breed the population of `generation`, (population, genes), as `breed_each` does several."""
    bred = breed_each(experiment, space, genomes[None], scores[None], generation, island)
    only: Genomes = bred[0]
    return only


def breed_each(
    experiment: Experiment,
    space: GenomeSpace,
    genomes: Genomes,
    scores: NDArray[np.float64],
    generation: int,
    island: int = 0,
) -> Genomes:
    """Breed several populations that share the random streams of a generation.

    Elites are copied. Parents are selected and crossed, their children mutated and
    repaired. Children beyond the population's size are dropped.

    Args:
        experiment: its scheme and seed.
        space: the genome space.
        genomes: the populations before, (populations, population, genes); not changed.
        scores: (populations, population), more is better.
        generation: number of the generation to breed, from 2.
        island: number of the island, which has random streams of its own.

    Returns:
        (populations, population, genes): of each the elites, best first, then the children.

    Raises:
        PluginError: an operator fails or breaks its contract; names its package.
    """
    populations, size, genes = genomes.shape
    elites = experiment.evolution.elites
    wanted = size - elites
    # Stable, so that of equal scores the first stays first.
    best = np.argsort(-scores, axis=1, kind="stable")[:, :elites]
    selection = _at(experiment, "selection", experiment.selection, generation)
    crossover = _at(experiment, "crossover", experiment.crossover, generation)
    pairs = -(-wanted // crossover.children)
    # Each operator gets arrays of its own, which it may change.
    parents = _parents(
        experiment,
        selection,
        scores.copy(),
        pairs,
        stream(experiment.seed, generation, Purpose.SELECTION, island),
    )
    # All populations in one list of individuals, for operators that see rows alone.
    everyone = genomes.reshape(-1, genes)
    rows = (parents + size * np.arange(populations)[:, None, None]).reshape(-1, 2)
    with plugin_errors(experiment.entries["crossover"], "crossing parents"):
        children = crossover.cross(
            everyone[rows[:, 0]],
            everyone[rows[:, 1]],
            space,
            stream(experiment.seed, generation, Purpose.CROSSOVER, island),
        )
    _check_children(experiment, "crossover", children, len(rows) * crossover.children, space)
    # First children of all pairs, then second ones: brought together by population.
    families = children.reshape(crossover.children, populations, pairs, genes)
    families = families.swapaxes(0, 1).reshape(populations, -1, genes)[:, :wanted]
    children = _mutated(experiment, space, families.reshape(-1, genes), generation, island)
    kept = np.take_along_axis(genomes, best[:, :, None], axis=1)
    return np.concatenate([kept, children.reshape(populations, wanted, genes)], axis=1)


def _mutated(
    experiment: Experiment, space: GenomeSpace, genomes: Genomes, generation: int, island: int
) -> Genomes:
    """Return the genomes mutated and repaired, (individuals, genes)."""
    mutation = _at(experiment, "mutation", experiment.mutation, generation)
    with plugin_errors(experiment.entries["mutation"], "mutating children"):
        mutants = mutation.mutate(
            genomes, space, stream(experiment.seed, generation, Purpose.MUTATION, island)
        )
    _check_children(experiment, "mutation", mutants, len(genomes), space)
    with plugin_errors(experiment.entries["organism"], "repairing genomes"):
        mutants = space.repair(mutants)
        belong = space.contains(mutants) and len(mutants) == len(genomes)
    if not belong:
        raise contract_error(
            experiment.entries["organism"], "repairs genomes to ones that are not of its space"
        )
    return mutants


_Scheduled = TypeVar("_Scheduled", bound=Plugin)


def _at(experiment: Experiment, kind: str, plugin: _Scheduled, generation: int) -> _Scheduled:
    """Return the plugin with its options at this generation."""
    with plugin_errors(experiment.entries[kind], "following its schedule"):
        return plugin.at(generation)


def _parents(
    experiment: Experiment,
    selection: Selection,
    scores: NDArray[np.float64],
    pairs: int,
    rng: np.random.Generator,
) -> NDArray[np.intp]:
    """Select parents in every population, (populations, pairs, 2), and check the indices."""
    populations, size = scores.shape
    with plugin_errors(experiment.entries["selection"], "selecting parents"):
        if populations == 1:
            parents = selection.parents(scores[0], pairs, rng)
        else:
            parents = selection.parents_each(scores, pairs, rng)
    shape = (pairs, 2) if populations == 1 else (populations, pairs, 2)
    _check_form(experiment, "selection", parents, shape, np.dtype(np.intp))
    if not ((parents >= 0) & (parents < size)).all():
        raise contract_error(
            experiment.entries["selection"],
            f"chose the parents {parents.min()} to {parents.max()}",
            f"indices from 0 to {size - 1}",
        )
    return parents.reshape(populations, pairs, 2)


def _check_children(
    experiment: Experiment, kind: str, children: Genomes, count: int, space: GenomeSpace
) -> None:
    """Check that repairing can bring the genomes of crossover or mutation into the space."""
    _check_form(experiment, kind, children, (count, space.genes), space.dtype)
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        raise contract_error(
            experiment.entries[kind], "returned genes that are not finite", "finite genes"
        )
    if isinstance(space, BitSpace) and not (children <= 1).all():
        raise contract_error(
            experiment.entries[kind], "returned genes that are not bits", "0 and 1"
        )


def _check_form(
    experiment: Experiment,
    kind: str,
    result: object,
    shape: tuple[int, ...],
    dtype: np.dtype[np.generic],
) -> None:
    """Check the shape and dtype that the contract of an operator requires."""
    if isinstance(result, np.ndarray) and result.shape == shape and result.dtype == dtype:
        return
    actual = (
        f"shape {result.shape}, dtype {result.dtype}"
        if isinstance(result, np.ndarray)
        else type(result).__name__
    )
    raise contract_error(
        experiment.entries[kind], f"returned {actual}", f"an array of shape {shape}, dtype {dtype}"
    )
