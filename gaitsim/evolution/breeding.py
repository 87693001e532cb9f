"""Breeding: one population from the one before, a pure function of seed and generation."""

from enum import IntEnum
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, BitSpace, Genomes, GenomeSpace, Plugin, Selection
from gaitsim.experiment import Experiment
from gaitsim.registry import Entry, contract_error, plugin_errors


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


def initial_population(
    experiment: Experiment, space: GenomeSpace, island: int = 0, populations: int = 1
) -> Genomes:
    """Draw generation 1 of one population or of several, (individuals, genes)."""
    count = populations * experiment.evolution.population
    rng = stream(experiment.seed, 1, Purpose.INITIAL, island)
    body = experiment.entries["organism"]
    with plugin_errors(body, "drawing genomes"):
        genomes = space.random(count, rng)
        belongs = space.contains(genomes) and len(genomes) == count
    if not belongs:
        raise contract_error(body, "draws genomes that are not of its own space")
    return genomes


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
    """Breed a population, or several that share the random streams of a generation.

    Elites are copied. Parents are selected and crossed, their children mutated and
    repaired. Children beyond the population's size are dropped.

    Args:
        experiment: its scheme and seed.
        space: the genome space.
        genomes: the generation before, (population, genes), or that of several populations,
            (populations, population, genes); not changed.
        scores: of these, without the last axis; more is better.
        generation: number of the generation to breed, from 2.
        island: number of the island, which has random streams of its own.

    Returns:
        In the shape of `genomes`: of each population the elites, best first, then the children.

    Raises:
        PluginError: an operator fails or breaks its contract; names its package.
    """
    *several, size, genes = genomes.shape
    genomes, scores = genomes.reshape(-1, size, genes), scores.reshape(-1, size)
    populations, elites = len(genomes), experiment.evolution.elites
    wanted = size - elites
    if elites == 1:  # in a fiftieth of the time
        best = scores.argmax(axis=1)[:, None]
    else:  # stable, so that of equal scores the first stays first
        best = np.argsort(-scores, axis=1, kind="stable")[:, :elites]
    selection = _at(experiment, "selection", experiment.selection, generation)
    crossover = _at(experiment, "crossover", experiment.crossover, generation)
    pairs = -(-wanted // crossover.children)
    rng = stream(experiment.seed, generation, Purpose.SELECTION, island)
    parents = _parents(experiment.entries["selection"], selection, scores, pairs, rng)
    # All populations in one list of individuals, for operators that see rows alone.
    everyone = genomes.reshape(-1, genes)
    rows = (parents + size * np.arange(populations)[:, None, None]).reshape(-1, 2)
    rng = stream(experiment.seed, generation, Purpose.CROSSOVER, island)
    with plugin_errors(experiment.entries["crossover"], "crossing parents"):
        mothers, fathers = (everyone.take(chosen, axis=0) for chosen in rows.T)
        children = crossover.cross(mothers, fathers, space, rng)
    count = len(rows) * crossover.children
    _check_children(experiment.entries["crossover"], children, count, space)
    # First children of all pairs, then second ones: brought together by population.
    families = children.reshape(crossover.children, populations, pairs, genes)
    families = families.swapaxes(0, 1).reshape(populations, -1, genes)[:, :wanted]
    children = _mutated(experiment, space, families.reshape(-1, genes), generation, island)
    kept = np.take_along_axis(genomes, best[:, :, None], axis=1)
    bred = np.concatenate([kept, children.reshape(populations, wanted, genes)], axis=1)
    return bred.reshape(*several, size, genes)


def _mutated(
    experiment: Experiment, space: GenomeSpace, genomes: Genomes, generation: int, island: int
) -> Genomes:
    """Return the genomes mutated and repaired, (individuals, genes)."""
    mutation = _at(experiment, "mutation", experiment.mutation, generation)
    rng = stream(experiment.seed, generation, Purpose.MUTATION, island)
    with plugin_errors(experiment.entries["mutation"], "mutating children"):
        mutants = mutation.mutate(genomes, space, rng)
    _check_children(experiment.entries["mutation"], mutants, len(genomes), space)
    body = experiment.entries["organism"]
    with plugin_errors(body, "repairing genomes"):
        mutants = space.repair(mutants)
        belong = space.contains(mutants) and len(mutants) == len(genomes)
    if not belong:
        raise contract_error(body, "repairs genomes to ones that are not of its space")
    return mutants


_Scheduled = TypeVar("_Scheduled", bound=Plugin)


def _at(experiment: Experiment, kind: str, plugin: _Scheduled, generation: int) -> _Scheduled:
    """Return the plugin with its options at this generation."""
    with plugin_errors(experiment.entries[kind], "following its schedule"):
        return plugin.at(generation)


def _parents(
    entry: Entry,
    selection: Selection,
    scores: NDArray[np.float64],
    pairs: int,
    rng: np.random.Generator,
) -> NDArray[np.intp]:
    """Select parents in every population, (populations, pairs, 2), and check the indices."""
    populations, size = scores.shape
    lent = scores.copy()  # each operator gets arrays of its own, which it may change
    with plugin_errors(entry, "selecting parents"):
        if populations == 1:
            parents = selection.parents(lent[0], pairs, rng)
        else:
            parents = selection.parents_each(lent, pairs, rng)
    shape = (pairs, 2) if populations == 1 else (populations, pairs, 2)
    _check_form(entry, parents, shape, np.dtype(np.intp))
    if not ((parents >= 0) & (parents < size)).all():
        chosen = f"chose the parents {parents.min()} to {parents.max()}"
        raise contract_error(entry, chosen, f"indices from 0 to {size - 1}")
    return parents.reshape(populations, pairs, 2)


def _check_children(entry: Entry, children: Genomes, count: int, space: GenomeSpace) -> None:
    """Check that repairing can bring the genomes of crossover or mutation into the space."""
    _check_form(entry, children, (count, space.genes), space.dtype)
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        raise contract_error(entry, "returned genes that are not finite", "finite genes")
    if isinstance(space, BitSpace) and not children.max() <= 1:
        raise contract_error(entry, "returned genes that are not bits", "0 and 1")


def _check_form(
    entry: Entry, result: object, shape: tuple[int, ...], dtype: np.dtype[np.generic]
) -> None:
    """Check the shape and dtype that the contract of an operator requires."""
    actual = type(result).__name__
    if isinstance(result, np.ndarray):
        if result.shape == shape and result.dtype == dtype:
            return
        actual = f"shape {result.shape}, dtype {result.dtype}"
    raise contract_error(entry, f"returned {actual}", f"an array of shape {shape}, dtype {dtype}")
