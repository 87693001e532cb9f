"""The contract of a search: ask for genomes, tell their scores, keep a state of named arrays."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.motion import Array
from gaitsim.contracts.plugin import Plugin
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace

State = Mapping[str, Array]
"""All that a search knows, as named arrays of float64, int64, uint8 or bool.

A checkpoint holds it, so it must be enough to continue to the bit. Names and dtypes stay as
`Search.initial` gives them; shapes may change, as those of an archive do.
"""

STATE_DTYPES = ("<f8", "<i8", "|u1", "|b1")
"""NumPy's names of these dtypes, as a checkpoint stores them."""


@dataclass(frozen=True, eq=False)
class Results:
    """An evaluated population.

    Attributes:
        genomes: (population, genes); of several populations (populations, population, genes).
        scores: of each genome, more is better; −inf for an individual that failed, never NaN.
        values: the terms and measures that `Search.reads` names, each in the shape of `scores`;
            for an individual that failed, they may be NaN.
    """

    genomes: Genomes
    scores: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Members:
    """The individuals that a search keeps: a Pareto front, or the elites of an archive.

    Attributes:
        genomes: (members, genes).
        scores: (members,).
        values: the objectives or axes by name, each (members,).
        cells: index of each one's cell in a grid, (members, axes), or in a tessellation,
            (members, 1), int64; None for a front.
        borders: borders of the cells along each axis, ascending, (cells + 1,) each; of a
            tessellation the two ends of the axis. None for a front.
        centroids: centre of each Voronoi cell in the units of the axes, (cells, axes), where the
            distances are in shares of the axes' lengths; None for a grid or a front.
    """

    genomes: Genomes
    scores: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]
    cells: NDArray[np.int64] | None = None
    borders: Mapping[str, NDArray[np.float64]] | None = None
    centroids: NDArray[np.float64] | None = None


class Operators(Protocol):
    """The operators of the experiment at this generation, each with random streams of its own.

    All take several populations at once, with one more axis in front.
    """

    def parents(self, scores: NDArray[np.float64], children: int) -> NDArray[np.intp]:
        """Select parents of that many children: scores (population,) -> indices (pairs, 2)."""

    def cross(self, genomes: Genomes, parents: NDArray[np.intp], children: int) -> Genomes:
        """Cross the parents, indices into the genomes (population, genes) -> (children, genes)."""

    def mutate(self, genomes: Genomes) -> Genomes:
        """Mutate and repair every genome, (population, genes) -> new array."""


@dataclass(frozen=True, eq=False)
class Context:
    """What a search works with in one call.

    Attributes:
        space: the genome space of the body.
        population: individuals in each generation.
        generation: number of the generation asked for or told, from 1.
        rng: the only source of randomness; a stream of its own for each call in each generation.
        start: genome that the first generation begins from, (genes,); None begins at random.
        populations: shape in front of `population` where a search takes several populations at
            once, () for one.
        operators: the experiment's selection, crossover and mutation, for a search that
            declares them.
    """

    space: GenomeSpace
    population: int
    generation: int
    rng: np.random.Generator
    start: Array | None = None
    populations: tuple[int, ...] = ()
    operators: Operators | None = None

    def random(self, count: int) -> Genomes:
        """Draw genomes as the body does, (count, genes)."""
        return self.space.random(count, self.rng)

    def repair(self, genomes: Genomes) -> Genomes:
        """Return the genomes with genes outside the space brought back into it."""
        return self.space.repair(genomes)


class Search(Plugin):
    """Searches for genomes with high scores: pure functions over a state of named arrays.

        initial ─▶ state ─▶ ask ─▶ genomes ─▶ evaluated elsewhere ─▶ tell ─▶ state ─▶ ask …

    Nothing is kept in the plugin itself. A generation is what one `ask` returns; it always has
    `Context.population` genomes. A search whose own populations are larger, as after a restart of
    CMA-ES, spreads them over several generations.

    Attributes:
        spaces: the genome spaces it works on.
        operators: the kinds of operators that it uses, sections of the experiment.
        several: whether `ask` takes several populations at once, `Context.populations`, and its
            state is empty; islands need it.
        keeps: what `members` are: a Pareto 'front', an 'archive', or nothing. A search that keeps
            a front has an option `objectives`, 'max' or 'min' by name, in the order of
            `Members.values`; its members are sorted by the first one.
    """

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)
    operators: ClassVar[tuple[str, ...]] = ()
    several: ClassVar[bool] = False
    keeps: ClassVar[Literal["", "front", "archive"]] = ""

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why this search cannot work in this space with this population, or ''."""
        return ""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the terms and measures that `Results.values` has to hold."""
        return ()

    def initial(self, context: Context) -> State:
        """Return the state before the first generation."""
        return {}

    @abstractmethod
    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return the genomes of the next generation, and the state until they are told.

        Args:
            state: after the generation before; its arrays must not be changed.
            last: the generation before, which every checkpoint holds beside the state; None for
                the first generation.
            context: space, size and randomness.

        Returns:
            Genomes of the space, (population, genes), and the state.
        """

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Return the state after the evaluation of the genomes that `ask` returned."""
        return state

    def figures(self, state: State) -> Mapping[str, float]:
        """Return numbers about the search for the history, such as coverage; always the same names.

        A name is one for people, such as 'step size'.
        """
        return {}

    def members(self, state: State) -> Members | None:
        """Return the individuals that the search keeps; None for a search that keeps none."""
        return None

    def remembered(self, state: State) -> Genomes | None:
        """Return the genomes whose scores the state holds, (genomes, genes); None without any.

        They are re-evaluated where the body, the fitness or the worlds of a run are changed, and
        where worlds are redrawn, between `ask` and `tell`.
        """
        return None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores and values of its `remembered` genomes."""
        return state

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit this search with its options, or ''.

        Called where a run is resumed, perhaps with other options. Names and dtypes are
        checked already.
        """
        return ""
