"""MAP-Elites: an archive of the best genome in each cell of a space of measures."""

import math
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gaitsim.plugin import (
    BitSpace,
    Context,
    Genomes,
    GenomeSpace,
    Members,
    RealSpace,
    Results,
    Search,
    State,
    option,
)
from gaitsim.plugin.toolkit import standard_normal
from gaitsim_searches.archive import Archive, Candidates, Tessellation, even_centroids
from gaitsim_searches.emitters import (
    Emitters,
    SoftThresholds,
    adapt_emitters,
    draw_genomes,
    improvement,
    with_soft_thresholds,
)
from gaitsim_searches.real import differences, real_space


def mutate_all_genes(
    genomes: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Add a normally distributed change to every gene; `sigma` is in widths of the bounds."""
    return genomes + sigma * space.width * standard_normal(rng, genomes.shape)


def line_shifts(
    genomes: Genomes, others: Genomes, space: RealSpace, sigma: float, rng: np.random.Generator
) -> Genomes:
    """Return a shift of each genome along the line to another genome.

    The shift, as a share of the distance, is normal with standard deviation `sigma`. Periodic genes
    take the shorter way round. Vassiliades and Mouret 2018, "Discovering the elite hypervolume by
    leveraging interspecies correlation".
    """
    shift: Genomes = differences(others, genomes, space)
    return shift * (sigma * standard_normal(rng, (len(genomes), 1)))


def flip_bits(genomes: Genomes, flips: float, rng: np.random.Generator) -> Genomes:
    """Flip `flips` bits of each genome on average."""
    flip = rng.random(genomes.shape) * genomes.shape[1] < flips
    return np.where(flip, 1 - genomes, genomes)


def uniform_crossover(genomes: Genomes, others: Genomes, rng: np.random.Generator) -> Genomes:
    """Take each bit from one of two genomes at random (Syswerda 1989)."""
    return np.where(rng.random(genomes.shape) < 0.5, genomes, others)


_MOST_CELLS = 1_000_000
_MOST_CENTROIDS = 200_000
_MOST_BYTES = 64_000_000
_FARTHEST = 1e100  # largest end of an axis, so that differences are finite


class _VaryingOperators:
    """The operators of a MAP-Elites search; the class itself shows all that it may use."""

    def __get__(self, search: "MapElites | None", owner: type) -> tuple[str, ...]:
        unused = search is not None and search.variation != "operators"
        return () if unused else ("crossover", "mutation")


class MapElites(Search):
    """Keeps the best genome found in each cell of a space of measures.

    Mouret and Clune 2015, "Illuminating search spaces by mapping elites". The variations are the
    article's isotropic variation, the line variation of Vassiliades and Mouret 2018, and the
    emitters CMA-ME (Fontaine et al. 2020) and CMA-MAE (Fontaine and Nikolaidis 2023) as in pyribs.
    Voronoi cells: Vassiliades, Chatzilygeroudis and Mouret 2018.
    """

    axes: dict[str, tuple[float, float]] = option(
        ..., "measures or terms of the score that span the archive, each with its low and high end"
    )
    cells: (
        Annotated[int, Field(ge=2, le=_MOST_CENTROIDS)]
        | tuple[Annotated[int, Field(ge=1, le=_MOST_CELLS)], ...]
    ) = option(
        1_000,
        "number of Voronoi cells, or several numbers: the number of cells along each axis of a "
        "grid",
    )
    variation: Literal["isotropic", "line", "cma-me", "cma-mae", "operators"] = option(
        "line",
        "method that creates new genomes from elites; 'operators' uses the experiment's crossover "
        "and mutation, for genomes of any kind",
    )
    sigma: float = option(
        0.03,
        "standard deviation of the change in a gene with the variations 'isotropic' and 'line', as "
        "a share of the gene's range",
        ge=0,
        le=10,
    )
    line_sigma: float = option(
        0.2,
        "standard deviation of the step towards another elite, as a share of the distance",
        ge=0,
        le=10,
    )
    flips: float = option(
        1.0, "mean number of bits that the variations 'isotropic' and 'line' flip", gt=0
    )
    step: float = option(
        0.2, "initial step size of an emitter, as a share of each gene's range", gt=0, le=10
    )
    emitters: int = option(5, "number of emitters that share a generation", ge=1, le=1_000)
    learning_rate: float = option(
        0.01,
        "rate at which the thresholds of 'cma-mae' rise, from 0 (never) to 1 (at once)",
        ge=0,
        le=1,
    )
    threshold: float = option(
        0.0, "score that a genome must exceed in an empty cell with 'cma-mae'", ge=-1e100, le=1e100
    )
    random: int = option(
        1,
        "number of random generations before the first variation; half of the first consists of "
        "start points and variations of them, if there are any",
        ge=1,
    )
    offset: float = option(
        0.0, "number subtracted from each elite's score in the QD score", ge=-1e100, le=1e100
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)
    operators: ClassVar[Any] = _VaryingOperators()
    keeps: ClassVar[Literal["", "front", "archive"]] = "archive"

    @model_validator(mode="after")
    def _check_cells(self) -> "MapElites":
        if not self.axes:
            raise ValueError("'axes' must name at least one measure, such as { speed = [0, 1] }")
        for name, (low, high) in self.axes.items():
            if not low < high:
                raise ValueError(
                    f"the low end of the axis {name!r}, {low:g}, must be below {high:g}"
                )
            if max(-low, high) > _FARTHEST:
                raise ValueError(
                    f"the ends of the axis {name!r} must be from {-_FARTHEST:g} to {_FARTHEST:g}"
                )
        if isinstance(self.cells, tuple):
            if len(self.cells) != len(self.axes):
                raise ValueError(
                    f"'cells' has {len(self.cells)} counts for {len(self.axes)} axes; "
                    "give one count per axis, or a single number, for Voronoi cells"
                )
            if math.prod(self.cells) > _MOST_CELLS:
                raise ValueError(
                    f"a grid of {math.prod(self.cells):,} cells is too large: at most "
                    f"{_MOST_CELLS:,} are allowed; give fewer cells per axis, or a "
                    "single number, for Voronoi cells"
                )
        return self

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the variation does not support these genes or this population, or ''."""
        if self.variation == "operators":
            return ""
        if not isinstance(space, RealSpace | BitSpace):
            return (
                f"the variation {self.variation!r} supports only real genes and bits, not genes of "
                f"the kind {space.name!r}; use 'operators'"
            )
        if not self._emits:
            return ""
        if not isinstance(space, RealSpace):
            return (
                f"the variation {self.variation!r} supports only real genes, not bits; "
                "use 'line' or 'isotropic'"
            )
        if population < 2 * self.emitters:
            return (
                f"a population of {population} is too small for {self.emitters} emitters, which "
                f"need two genomes each; use at least {2 * self.emitters}, or fewer emitters"
            )
        size = 2 * self.emitters * space.genes * space.genes * 8
        if size > _MOST_BYTES:
            return (
                f"the covariances of {self.emitters} emitters with {space.genes:,} genes would "
                f"take {size / 1e6:,.0f} MB in every checkpoint, but at most "
                f"{_MOST_BYTES / 1e6:.0f} MB are allowed; "
                "use fewer emitters, or the variation 'line'"
            )
        return ""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the axes."""
        return tuple(self.axes)

    def initial(self, context: Context) -> State:
        """Return an empty archive and its cells."""
        ranges = np.array(list(self.axes.values()), float)
        counts, centroids = np.empty(0, np.int64), np.empty((0, len(ranges)))
        if isinstance(self.cells, tuple):
            counts = np.array(self.cells, np.int64)
        else:
            centroids = even_centroids(self.cells, len(ranges), context.rng)
        genomes = np.empty((0, context.space.genes), context.space.dtype)
        return {
            "axes": self._names,
            "ranges": ranges,
            "counts": counts,
            "centroids": centroids,
            **Archive.empty(genomes, len(ranges)).arrays(),
            **Emitters.create(np.empty((0, context.space.genes)), self.step).arrays(),
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return random genomes at first, later variations of elites or samples of the emitters."""
        archive, emitters = Archive.from_state(state), Emitters.from_state(state)
        if context.generation <= self.random or not len(archive.cells):
            none = Emitters.create(np.empty((0, context.space.genes)), self.step)
            genomes = context.begin(0.5, lambda starts: self._varied(starts, starts, context))
            return genomes, {**state, **none.arrays()}
        if self._emits:
            if len(emitters.mean) != self.emitters:
                means = self._elites(archive, self.emitters, context)
                emitters = Emitters.create(means, self.step)
                state = {**state, **emitters.arrays()}
            genomes = draw_genomes(
                emitters, context.population, real_space(context.space), context.rng
            )
        else:
            rows = context.rng.integers(0, len(archive.cells), context.population)
            others = np.full_like(rows, -1)
            if self.variation in ("line", "operators"):
                others = context.rng.integers(0, len(archive.cells), context.population)
            parents, elites = np.stack([rows, others], axis=1), archive.genomes[rows]
            if context.operators is None:
                context.record_parents(parents)
                genomes = self._varied(elites, archive.genomes[others], context)
            else:
                crossed = context.operators.cross(archive.genomes, parents, context.population)
                context.record_parents(parents, crossed)
                genomes = context.operators.mutate(crossed)
        return context.repair(genomes), state

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Insert the genomes into the archive, and adapt the emitters to the improvement."""
        before, candidates = Archive.from_state(state), self._candidates(state, results)
        after = self._inserted(before, candidates)
        emitters = Emitters.from_state(state)
        if self._emits and len(emitters.mean):
            found = improvement(before, candidates, self._soft)
            emitters, ended = adapt_emitters(
                emitters,
                results.genomes,
                found,
                real_space(context.space),
                two_stages=self._soft is None,
            )
            emitters = replace(emitters, mean=context.repair(emitters.mean))
            if ended.any():
                origins = self._elites(after, len(ended), context)
                emitters = emitters.replaced(ended, Emitters.create(origins, self.step))
        return {**state, **after.arrays(), **emitters.arrays()}

    def figures(self, state: State) -> dict[str, float]:
        """Return coverage, QD score and the best elite's score, −inf without elites."""
        scores = state["scores"]
        return {
            "coverage": len(scores) / _tessellation(state).total,
            "QD score": float(np.sum(scores - self.offset)),
            "best elite": float(scores.max(initial=-np.inf)),
        }

    def members(self, state: State) -> Members:
        """Return the elites in the order of their cells."""
        archive = Archive.from_state(state)
        values = dict(zip(self.axes, archive.values.T, strict=True))
        tessellation = _tessellation(state)
        return Members(
            archive.genomes,
            archive.scores,
            values,
            tessellation.indices(archive.cells),
            dict(zip(self.axes, tessellation.borders, strict=True)),
            tessellation.centres,
        )

    def remembered(self, state: State) -> Genomes:
        """Return the genomes of the elites."""
        return state["genomes"]

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Rebuild the archive with new scores and values; elites may change or lose their cells."""
        empty = Archive.empty(results.genomes, len(self.axes))
        return {**state, **self._inserted(empty, self._candidates(state, results)).arrays()}

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit the axes, cells or genes, or ''."""
        names = bytes(state["axes"]).decode(errors="replace").split("\0")
        if names != list(self.axes):
            return f"its archive has different axes: {', '.join(names)}"
        ranges = np.array(list(self.axes.values()), float)
        if not np.array_equal(state["ranges"], ranges):
            return "its archive has different ranges of the axes"
        counts, centroids = state["counts"], state["centroids"]
        cells = tuple(map(int, counts)) if len(counts) else len(centroids)
        if cells != self.cells:
            return f"its archive has different cells: {cells}"
        if not context.space.contains(state["genomes"]):
            return "its archive is of a body with different genes or bounds"
        archive, total = Archive.from_state(state), _tessellation(state).total
        complete = len(counts) > 0 or (
            centroids.shape == (total, len(names)) and bool(np.isfinite(centroids).all())
        )
        if not (
            complete
            and archive.is_consistent(total, len(names))
            and Emitters.from_state(state).is_consistent(context.space.genes)
        ):
            return "its archive has inconsistent arrays"
        return ""

    @property
    def _emits(self) -> bool:
        return self.variation in ("cma-me", "cma-mae")

    @property
    def _soft(self) -> SoftThresholds | None:
        return (
            SoftThresholds(self.threshold, self.learning_rate)
            if self.variation == "cma-mae"
            else None
        )

    @property
    def _names(self) -> NDArray[np.uint8]:
        return np.frombuffer("\0".join(self.axes).encode(), np.uint8)

    def _elites(self, archive: Archive, count: int, context: Context) -> Genomes:
        """Draw elites, (count, genes); without elites, random genomes."""
        if len(archive.cells):
            return archive.genomes[context.rng.integers(0, len(archive.cells), count)]
        return context.random(count)

    def _varied(self, elites: Genomes, others: Genomes, context: Context) -> Genomes:
        """Return variations of elites, (count, genes), along the line to others if so chosen."""
        line = self.variation == "line"
        if context.operators is not None:  # start points
            return context.operators.mutate(elites)
        if isinstance(context.space, RealSpace):
            changed = mutate_all_genes(elites, context.space, self.sigma, context.rng)
            if not line:
                return changed
            shift = line_shifts(elites, others, context.space, self.line_sigma, context.rng)
            return changed + shift
        parents = uniform_crossover(elites, others, context.rng) if line else elites
        return flip_bits(parents, self.flips, context.rng)

    def _candidates(self, state: State, results: Results) -> Candidates:
        values = np.stack([results.values[name] for name in self.axes], 1)
        cells = _tessellation(state).cells(values)
        return Candidates(cells, results.genomes, results.scores, values)

    def _inserted(self, before: Archive, candidates: Candidates) -> Archive:
        after = before.inserted(candidates)
        return with_soft_thresholds(before, after, candidates, self._soft) if self._soft else after


def _tessellation(state: State) -> Tessellation:
    return Tessellation(state["ranges"], state["counts"], state["centroids"])
