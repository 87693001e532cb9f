"""The context of a search: its random streams and operators, which are checked, and its state."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import BitSpace, Context, Crossover, Genomes, GenomeSpace, Members, State
from gaitsim.contracts.search import BODY_STARTS, NO_STARTS, RANDOM_START, STATE_DTYPES
from gaitsim.evaluation.streams import Purpose, stream
from gaitsim.experiment import Experiment
from gaitsim.registry import Entry, contract_error, plugin_errors


@dataclass(frozen=True, eq=False)
class ExperimentOperators:
    """The `gaitsim.contracts.Operators` of one generation of one island.

    Attributes:
        experiment: experiment with the operators and the seed.
        space: genome space.
        generation: number of the generation to breed; schedules of operators depend on it.
        island: number of the island; each island has its own random streams.
    """

    experiment: Experiment
    space: GenomeSpace
    generation: int
    island: int = 0

    def parents(self, scores: NDArray[np.float64], children: int) -> NDArray[np.intp]:
        """Return the indices of selected parents, (…, pairs, 2), by scores, (…, population)."""
        entry, selection = self._at("selection")
        *several, size = scores.shape
        pairs = -(-children // self._crossover.children)
        rows = scores.reshape(-1, size).copy()  # a copy, because the operator may change it
        with plugin_errors(entry, "selecting parents"):
            if len(rows) == 1:
                parents = selection.parents(rows[0], pairs, self._rng(Purpose.SELECTION))
            else:
                parents = selection.parents_each(rows, pairs, self._rng(Purpose.SELECTION))
        shape = (pairs, 2) if len(rows) == 1 else (len(rows), pairs, 2)
        _check_array(entry, parents, shape, np.dtype(np.intp))
        if not ((parents >= 0) & (parents < size)).all():
            chosen = f"chose the parents {parents.min()} to {parents.max()}"
            raise contract_error(entry, chosen, f"indices from 0 to {size - 1}")
        found: NDArray[np.intp] = parents.reshape(*several, pairs, 2)
        return found

    def cross(self, genomes: Genomes, parents: NDArray[np.intp], children: int) -> Genomes:
        """Return children, (…, children, genes), of parents in genomes, (…, population, genes)."""
        entry, crossover = self.experiment.entries["crossover"], self._crossover
        *several, size, genes = genomes.shape
        pairs = parents.shape[-2]
        # Operators see the individuals of all populations as the rows of one array.
        everyone, chosen = genomes.reshape(-1, genes), parents.reshape(-1, pairs, 2)
        rows = (chosen + size * np.arange(len(chosen))[:, None, None]).reshape(-1, 2)
        rng = self._rng(Purpose.CROSSOVER)
        with plugin_errors(entry, "crossing parents"):
            mothers, fathers = (everyone.take(one, axis=0) for one in rows.T)
            crossed = crossover.cross(mothers, fathers, self.space, rng)
        _check_children(entry, crossed, len(rows) * crossover.children, self.space)
        if crossover.pair_probability < 1:
            kept = rng.random((len(rows), 1)) >= crossover.pair_probability
            copies = everyone.take(rows.T[: crossover.children], axis=0)
            crossed = np.where(kept, copies, crossed.reshape(copies.shape))
        # All first children precede all second ones; regroup them by population.
        families = crossed.reshape(crossover.children, len(chosen), pairs, genes).swapaxes(0, 1)
        found: Genomes = families.reshape(*several, -1, genes)[..., :children, :]
        return found

    def mutate(self, genomes: Genomes) -> Genomes:
        """Return mutated and repaired copies of genomes, (…, population, genes)."""
        entry, mutation = self._at("mutation")
        rows = genomes.reshape(-1, genomes.shape[-1])
        with plugin_errors(entry, "mutating children"):
            mutants = mutation.mutate(rows, self.space, self._rng(Purpose.MUTATION))
        _check_children(entry, mutants, len(rows), self.space)
        return repair_genomes(self.experiment, self.space, mutants).reshape(genomes.shape)

    @cached_property
    def _crossover(self) -> Crossover:
        crossover: Crossover = self._at("crossover")[1]
        return crossover

    def _at(self, kind: str) -> tuple[Entry, Any]:
        """Return the entry of an operator, and the operator with its options at this generation."""
        entry = self.experiment.entries[kind]
        with plugin_errors(entry, "applying its schedule"):
            return entry, self.experiment.plugin(kind).at(self.generation)

    def _rng(self, purpose: Purpose) -> np.random.Generator:
        return stream(self.experiment.seed, self.generation, purpose, self.island)


def repair_genomes(experiment: Experiment, space: GenomeSpace, genomes: Genomes) -> Genomes:
    """Repair genomes, (individuals, genes), so that they are in the body's genome space."""
    body = experiment.entries["organism"]
    with plugin_errors(body, "repairing genomes"):
        inside = space.repair(genomes)
        valid = space.contains(inside) and len(inside) == len(genomes)
    if not valid:
        raise contract_error(body, "repairs genomes to genomes outside its own genome space")
    return inside


def _check_children(entry: Entry, children: Genomes, count: int, space: GenomeSpace) -> None:
    """Check that the genomes from a crossover or mutation can be repaired."""
    _check_array(entry, children, (count, space.genes), space.dtype)
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        raise contract_error(entry, "returned genes that are not finite", "finite genes")
    if isinstance(space, BitSpace) and not children.max() <= 1:
        raise contract_error(entry, "returned genes that are not bits", "0 and 1")


def _check_array(
    entry: Entry, result: object, shape: tuple[int, ...], dtype: np.dtype[np.generic]
) -> None:
    """Check the shape and dtype that the contract of an operator requires."""
    actual = type(result).__name__
    if isinstance(result, np.ndarray):
        if result.shape == shape and result.dtype == dtype:
            return
        actual = f"shape {result.shape}, dtype {result.dtype}"
    raise contract_error(entry, f"returned {actual}", f"an array of shape {shape}, dtype {dtype}")


@dataclass(frozen=True, eq=False, kw_only=True)
class CheckedContext(Context):
    """A context that reports invalid genomes as errors of the body.

    Attributes:
        experiment: experiment of the search.
        redrawn: whether scores are replaced only because the worlds were redrawn.
    """

    experiment: Experiment
    redrawn: bool = False

    def random(self, count: int) -> Genomes:
        body = self.experiment.entries["organism"]
        with plugin_errors(body, "drawing genomes"):
            genomes = self.space.random(count, self.rng)
            valid = self.space.contains(genomes) and len(genomes) == count
        if not valid:
            raise contract_error(body, "draws genomes outside its own genome space")
        return genomes

    def repair(self, genomes: Genomes) -> Genomes:
        return repair_genomes(self.experiment, self.space, genomes)


def start_points(experiment: Experiment, space: GenomeSpace) -> Genomes:
    """Return the start points that the option `search.start` chooses, (starts, genes)."""
    chosen = experiment.search.start
    if chosen == RANDOM_START:
        return NO_STARTS
    found = experiment.starts()
    if chosen != BODY_STARTS:
        found = {chosen: found[chosen]}
    return np.array(list(found.values()), space.dtype).reshape(-1, space.genes)


def context(
    experiment: Experiment,
    space: GenomeSpace,
    generation: int,
    purpose: Purpose,
    *,
    island: int = 0,
    populations: tuple[int, ...] = (),
    starts: Genomes = NO_STARTS,
    redrawn: bool = False,
) -> CheckedContext:
    """Return the context of a call to the search of an experiment."""
    operators = None
    if experiment.search.operators:
        operators = ExperimentOperators(experiment, space, generation, island)
    return CheckedContext(
        space=space,
        population=experiment.evolution.population,
        generation=generation,
        rng=stream(experiment.seed, generation, purpose, island),
        starts=starts,
        populations=populations,
        operators=operators,
        experiment=experiment,
        redrawn=redrawn,
    )


class WrappedSearch:
    """A search around that of an experiment; subclasses add the other methods of `Search`.

    The state is that of the inner search, with arrays of its own, so that every checkpoint stores
    them.

    Attributes:
        prefix: prefix of the names of these arrays.
    """

    prefix: ClassVar[str]

    def __init__(self, experiment: Experiment) -> None:
        self._experiment, self._search = experiment, experiment.search

    def _inner(self, state: State) -> State:
        """Return the state of the inner search."""
        return {name: one for name, one in state.items() if not name.startswith(self.prefix)}

    def finished(self, state: State) -> str:
        """Return why the inner search ends the run, or ''."""
        return self._search.finished(self._inner(state))

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the figures of the inner search."""
        return self._search.figures(self._inner(state))

    def members(self, state: State) -> Members | None:
        """Return the members of the inner search."""
        return self._search.members(self._inner(state))

    def centre(self, state: State, space: GenomeSpace) -> Genomes | None:
        """Return the centre of the inner search."""
        return self._search.centre(self._inner(state), space)


@cache
def _is_name(name: object) -> bool:
    return isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200


_DTYPES = frozenset(map(np.dtype, STATE_DTYPES))


def check_state(experiment: Experiment, state: State) -> State:
    """Check a state; return it as plain arrays for a checkpoint."""
    entry = experiment.entries["search"]
    if not isinstance(state, Mapping):
        raise contract_error(entry, f"returned a {type(state).__name__} as its state", "a mapping")
    found = {}
    for name, values in state.items():
        if not _is_name(name):
            what = f"names an array of its state {name!r:.80}"
            raise contract_error(entry, what, "a printable string of 1 to 200 characters")
        if not isinstance(values, np.ndarray) or values.dtype not in _DTYPES:
            kind = values.dtype if isinstance(values, np.ndarray) else type(values).__name__
            raise contract_error(
                entry,
                f"stores {name!r} in its state as {kind}",
                "arrays of float64, int64, uint8 or bool",
            )
        # In C order, as a checkpoint restores arrays: the last bit of a sum depends on the order.
        plain = type(values) is np.ndarray and values.flags.c_contiguous
        found[name] = one = values if plain else np.asarray(values, order="C")
        one.setflags(write=False)
    return found
