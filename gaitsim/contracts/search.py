"""The contracts of fitness functions, searches and their operators."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import ceil, prod
from typing import ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.motion import Array, Motion
from gaitsim.contracts.plugin import Plugin, option
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace
from gaitsim.repr_mixin import ReprField, ReprMixin


class Fitness(Plugin):
    """A fitness function: named terms whose sum is the score; higher is better.

    Attributes:
        needs: names of the channels that the function reads.
        unit: unit of the score and of all its terms, as printed; `''` for pure numbers.
    """

    needs: ClassVar[tuple[str, ...]]
    unit: ClassVar[str] = ""

    @abstractmethod
    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the terms of the scores by name, each an array of shape (population,).

        The names must be the same for every motion. If a term of an individual is not finite, its
        score is −inf, and the run continues.
        """


class Selection(Plugin):
    """An operator that chooses parents."""

    @abstractmethod
    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents.

        Args:
            scores: score of each individual, (population,); higher is better. May contain −inf, but
                never NaN.
            pairs: number of pairs to choose.
            rng: only source of randomness.

        Returns:
            Indices of the mother and the father of each pair, (pairs, 2).
        """

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents in each of several populations.

        The default calls `parents` for one population after another. Override it to handle all
        populations at once, which is faster.

        Args:
            scores: score of each individual, (populations, population).
            pairs: number of pairs to choose in each population.
            rng: only source of randomness.

        Returns:
            Indices into each population, (populations, pairs, 2). For a single population, they
            must equal the result of `parents`.
        """
        return np.stack([self.parents(row, pairs, rng) for row in scores])

    def objection(self, population: int, elites: int, children: int) -> str:
        """Return why this selection does not support populations of this size, or ''.

        Args:
            population: number of individuals in each generation.
            elites: number of individuals copied unchanged into the next generation.
            children: number of children per pair.
        """
        return ""


class Crossover(Plugin):
    """An operator that combines pairs of parents into children.

    Attributes:
        children: number of children per pair, an option of every crossover. A crossover that
            supports only one number narrows it to `Literal[1]` or `Literal[2]`.
        pair_probability: crossover probability p_c (Holland 1975), an option of every crossover.
            The breeding step replaces the children of pairs that are not crossed with copies of
            their parents.
        spaces: genome spaces that the crossover supports.
    """

    children: Literal[1, 2] = option(2, "number of children of each pair of parents")
    pair_probability: float = option(
        1.0,
        "probability that a pair is crossed; otherwise its first child is a copy of the mother, "
        "and its second child a copy of the father",
        ge=0,
        le=1,
    )
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Cross each mother with the father in the same row.

        Args:
            mothers: genomes, (pairs, genes).
            fathers: genomes, (pairs, genes).
            space: genome space of the parents.
            rng: only source of randomness.

        Returns:
            A new array of shape (pairs × children, genes) in the dtype of the space: the first
            child of every pair, then the second child of every pair. Genes may exceed their
            bounds; the breeding step repairs them after mutation.
        """


class Mutation(Plugin):
    """An operator that changes genomes at random.

    Attributes:
        spaces: genome spaces that the mutation supports.
    """

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of all genomes.

        Args:
            genomes: genomes to mutate, (population, genes).
            space: genome space of the genomes.
            rng: only source of randomness.

        Returns:
            A new array of the same shape and dtype. Genes may exceed their bounds; the breeding
            step repairs them.
        """


BODY_STARTS = "body"
"""The value of `Search.start` for all start points of the body."""

RANDOM_START = "random"
"""The value of `Search.start` for a random first generation."""

State = Mapping[str, Array]
"""Everything that a search remembers, as named arrays of float64, int64, uint8 or bool.

A checkpoint stores it, so it must suffice to continue the search bit for bit. Names and dtypes
must stay as `Search.initial` returned them; shapes may change, as an archive's do when it grows.
"""

STATE_DTYPES = ("<f8", "<i8", "|u1", "|b1")
"""NumPy's names of the dtypes that a state may have."""


@dataclass(frozen=True, eq=False)
class Results:
    """An evaluated population.

    Attributes:
        genomes: evaluated genomes, (population, genes); for several populations,
            (populations, population, genes).
        scores: score of each genome, −inf for a failed individual; never NaN. Higher is better.
        values: terms and measures that `Search.reads` names, each of the same shape as `scores`.
            They may be NaN for failed individuals.
    """

    genomes: Genomes
    scores: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Members(ReprMixin):
    """The individuals that a search keeps: a Pareto front, or the elites of an archive.

    Attributes:
        genomes: genome of each member, (members, genes).
        scores: score of each member, (members,).
        values: values of the objectives or axes by name, each of shape (members,).
        cells: index of each member's cell, int64: (members, axes) in a grid, (members, 1) in a
            tessellation; None for a front.
        borders: borders of the cells along each axis by name, ascending, each of shape
            (cells + 1,); for a tessellation, the two ends of the axis; None for a front.
        centroids: centre of each Voronoi cell in the units of the axes, (cells, axes); None for a
            grid or a front. In distances to a centre, each axis is scaled to length 1.
    """

    genomes: Genomes
    scores: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]
    cells: NDArray[np.int64] | None = None
    borders: Mapping[str, NDArray[np.float64]] | None = None
    centroids: NDArray[np.float64] | None = None

    def _repr_fields(self) -> Mapping[str, ReprField]:
        best = float(self.scores.max()) if len(self.scores) else ""
        return {"members": len(self.scores), "best": best, "values": ", ".join(self.values)}


class Operators(Protocol):
    """The operators of the experiment in this generation, each with its own random stream.

    All methods also accept several populations at once, as an additional first axis.
    """

    def parents(self, scores: NDArray[np.float64], children: int) -> NDArray[np.intp]:
        """Select parents for a number of children: indices (pairs, 2) into the scores."""

    def cross(self, genomes: Genomes, parents: NDArray[np.intp], children: int) -> Genomes:
        """Return children, (children, genes), of parents, indices (pairs, 2) into the genomes."""

    def mutate(self, genomes: Genomes) -> Genomes:
        """Return mutated and repaired copies of all genomes, (population, genes)."""


NO_STARTS: Genomes = np.empty((0, 0))
"""The start points of a random first generation."""

Parents = NDArray[np.int64]
"""Two parents of each genome, (population, 2): the main one, then the other; −1 for none.

They are rows of the genomes that the search remembered before `ask` (see `Search.remembered`), or
of the previous generation if it remembers none.
"""


def parents_of_children(pairs: NDArray[np.intp], children: int) -> Parents:
    """Return the parents of the children that `Operators.cross` returns, (…, children, 2).

    Args:
        pairs: pairs of parents, (…, pairs, 2), as passed to `cross`.
        children: number of children.
    """
    both = np.concatenate([pairs, pairs[..., ::-1]], axis=-2)
    return both[..., :children, :].astype(np.int64, copy=False)


@dataclass(frozen=True, eq=False)
class Context:
    """The space, sizes, randomness and operators that a search uses in one call.

    Attributes:
        space: genome space of the body.
        population: number of individuals in each generation.
        generation: number of the current generation, counted from 1.
        rng: only source of randomness; `ask` and `tell` get new streams in each generation.
        starts: start points, (starts, genes), the most promising first: genomes around which the
            first generation is drawn. Empty if it is random, and after the first generation.
        populations: shape of the axes before the population axis if the search handles several
            populations at once; () for a single population.
        operators: selection, crossover and mutation of the experiment, if the search declares
            that it uses them.
        record_parents: function that a search calls in `ask` with the `Parents` of the genomes that
            it returns, if they have any, so that `gaitsim lineage` can name them, and optionally
            with the genomes before mutation, which tell a crossed child from a copy.
    """

    space: GenomeSpace
    population: int
    generation: int
    rng: np.random.Generator
    starts: Genomes = field(default_factory=lambda: NO_STARTS)
    populations: tuple[int, ...] = ()
    operators: Operators | None = None
    record_parents: Callable[..., object] = lambda parents, before_mutation=None: None

    def random(self, count: int) -> Genomes:
        """Draw genomes from the body's space, (count, genes)."""
        return self.space.random(count, self.rng)

    def repair(self, genomes: Genomes) -> Genomes:
        """Return the genomes with every invalid gene replaced by a valid one."""
        return self.space.repair(genomes)

    def begin(self, share: float, vary: Callable[[Genomes], Genomes]) -> Genomes:
        """Return the first generation, (*populations, population, genes).

        Without start points, it is random. With start points, a share of it consists of the start
        points, followed by variations of them in turn; the rest is random.

        Args:
            share: share of each population that begins at start points.
            vary: function that returns variations of genomes, (…, count, genes).
        """
        shape = (*self.populations, self.population, self.space.genes)
        genomes = self.random(prod(shape[:-1])).reshape(shape)
        count, exact = ceil(share * self.population), len(self.starts)
        if exact:
            # np.resize repeats the rows.
            genomes[..., :count, :] = np.resize(self.starts, (count, shape[-1]))
            if count > exact:
                genomes[..., exact:count, :] = vary(genomes[..., exact:count, :].copy())
        return self.repair(genomes.reshape(-1, shape[-1])).reshape(shape)


class Search(Plugin):
    """A search for genomes with high scores: pure functions over a state of named arrays.

        initial ─▶ state ─▶ ask ─▶ genomes ─▶ evaluated elsewhere ─▶ tell ─▶ state ─▶ ask …

    The plugin itself keeps no state. Each `ask` returns the `Context.population` genomes of one
    generation. A search that needs larger populations, such as CMA-ES after a restart, spreads each
    of them over several generations.

    Attributes:
        start: start points from which the first generation is drawn, an option of every search. A
            search that never uses them narrows it to `Literal["random"]`.
        spaces: genome spaces that the search supports.
        operators: kinds of operators that the search uses; each is a section of the experiment.
        several: whether `ask` can handle several populations at once (see `Context.populations`)
            with an empty state. Islands require it.
        keeps: what `members` returns: 'front' for a Pareto front, 'archive' for an archive, '' for
            None. A search that keeps a front has an option `objectives` with 'max' or 'min' for
            each objective by name, in the order of `Members.values`; its members are sorted by the
            first objective.

    Examples:
        A library's object is restored from the state in each call. This search draws Sobol points
        with SciPy:

        ```python
        import numpy as np
        from scipy.stats import qmc

        from gaitsim.contracts import RealSpace, Search


        class SobolSearch(Search):
            spaces = (RealSpace,)

            def objection(self, space, population):
                if population & (population - 1) == 0:
                    return ""
                return f"the population must be a power of two, not {population}"

            def initial(self, context):
                seed = context.rng.integers(2**32)
                return {"seed": np.array(seed, np.int64), "drawn": np.array(0, np.int64)}

            def ask(self, state, last, context):
                space, drawn = context.space, int(state["drawn"])
                sequence = qmc.Sobol(space.genes, seed=int(state["seed"]))
                if drawn:
                    sequence.fast_forward(drawn)
                points = sequence.random(context.population)
                genomes = context.repair(space.lower + points * space.width)
                return genomes, {**state, "drawn": np.array(drawn + len(points), np.int64)}
        ```
    """

    start: str = option(
        BODY_STARTS,
        "where the search begins: 'body' begins around the body's start points, if it has any, "
        "such as 'tetrapod'; the name of one begins around it alone; 'random' begins with random "
        "genomes",
    )
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)
    operators: ClassVar[tuple[str, ...]] = ()
    several: ClassVar[bool] = False
    keeps: ClassVar[Literal["", "front", "archive"]] = ""

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why this search does not support this space and population size, or ''."""
        return ""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the terms and measures that `Results.values` must hold."""
        return ()

    def initial(self, context: Context) -> State:
        """Return the state before the first generation."""
        return {}

    @abstractmethod
    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return the genomes of the next generation, and the state to pass to `tell`.

        Args:
            state: state after the previous generation; its arrays must not be changed.
            last: evaluated previous generation, which every checkpoint stores together with the
                state; None in the first generation.
            context: space, sizes, randomness and operators.

        Returns:
            Valid genomes, (population, genes), and the state.
        """

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Return the state, updated with the results of the genomes that `ask` returned."""
        return state

    def finished(self, state: State) -> str:
        """Return why the search has nothing more to find and ends the run after `tell`, or ''.

        The reason is shown to users, such as 'the search has converged'. A run whose options change
        continues.
        """
        return ""

    def figures(self, state: State) -> Mapping[str, float]:
        """Return numbers about the search for the history, such as coverage.

        The names are shown to users, such as 'step size', and must be the same in every generation.
        """
        return {}

    def members(self, state: State) -> Members | None:
        """Return the individuals that the search keeps; None by default."""
        return None

    def centre(self, state: State, space: GenomeSpace) -> Genomes | None:
        """Return the genome amid those that `ask` draws, (genes,); None for other searches.

        `gaitsim lineage` shows it as their parent.
        """
        return None

    def remembered(self, state: State) -> Genomes | None:
        """Return the genomes whose scores the state contains, (genomes, genes); None by default.

        gaitsim re-evaluates them when the body, the fitness or the worlds of a run change, and,
        between `ask` and `tell`, when worlds are redrawn.
        """
        return None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores and values for its `remembered` genomes.

        Also called without genomes if `remembered` returns none, so that the search drops other
        scores, such as a history, which cannot be compared with new ones.
        """
        return state

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit this search with its options, or ''.

        Called when a run is resumed, possibly with different options, after the names and dtypes
        of the state have been checked.
        """
        return ""
