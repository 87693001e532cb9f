"""The search `designs`: the best gaits of many designs of a body, in independent replicates.

The last genes of a genome are factors of the body's dimensions. A run has three phases:

    original: CMA-ES finds a gait of the original body  ─▶  transfer: every design tries the gaits
    ─▶  polish: each design tries variations of its own gait and of those of other designs

A generation holds one individual of each design in each replicate. Replicates never exchange gaits,
so that the differences between them are the noise of the search.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    Context,
    Genomes,
    GenomeSpace,
    Members,
    RealSpace,
    Results,
    Search,
    State,
    load_class,
    option,
)

Floats = NDArray[np.float64]

GAITS = "cma-es"
"""The search for gaits of the original."""

FROM_OTHERS = 0.5
"""Share of the variations whose parent is the gait of another design."""

STEPS = 0.002, 0.2
"""Ends of the step sizes, as shares of the range of each gene; their logarithms are uniform."""


class Designs(Search):
    """Keeps the best gait of each of many designs of a body, in independent replicates.

    A design keeps the better of its gait and a variation of it, as the (1 + 1) evolution strategy
    of Rechenberg 1973 does; instead of adapting, step sizes are drawn from a wide range. Half of
    the parents are gaits of other designs, as in MAP-Elites (Mouret and Clune 2015).
    """

    dimensions: tuple[str, ...] = option(
        ..., "names of the dimensions, whose factors are the last genes"
    )
    levels: int = option(7, "factors of each dimension in a grid of designs", ge=3, le=1000)
    sample: int = option(
        0,
        "number of designs, the original among them, in a Latin hypercube instead of a grid",
        ge=0,
        le=100_000,
    )
    replicates: int = option(
        3, "independent repetitions, whose differences show the noise of the search", ge=1, le=1000
    )
    original: int = option(
        10, "generations that search for gaits of the original; 0 starts from known gaits", ge=0
    )
    speed: float = option(
        0.0,
        "speed that a gait should reach: of two gaits, the one closer to it from below is better, "
        "and if both reach it, the one with the higher score; 0 compares scores alone",
        unit="m/s",
        ge=0,
    )
    measures: tuple[str, ...] = option((), "measures of the best gaits that the run records")

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)
    keeps: ClassVar[Literal["", "front", "archive"]] = "archive"

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the genes or the population do not fit, or ''."""
        if not (isinstance(space, RealSpace) and 0 < len(self.dimensions) < space.genes):
            return f"the body has too few genes for {len(self.dimensions)} dimensions and a gait"
        if self.sample == 1 or (self.sample == 0 and self.levels ** len(self.dimensions) > 100_000):
            return "the number of designs must be from 2 to 100,000"
        low, high = self.ends(space)
        for name, least, most in zip(self.dimensions, low, high, strict=True):
            if not least <= 1 <= most:
                return f"the range of {name}, {least:g} to {most:g}, must contain the original, 1"
        count = len(designs_of(low, high, self.levels, self.sample, np.random.default_rng(0)))
        if population != count * self.replicates:
            return (
                f"the population must be {count * self.replicates}: {count} designs in "
                f"{self.replicates} replicates"
            )
        return self._gaits.objection(self._gait_space(space), count) if self.original else ""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the recorded measures, and the speed if one is to be reached."""
        return tuple(dict.fromkeys((*self.measures, *(["speed"] if self.speed else []))))

    def ends(self, space: RealSpace) -> tuple[Floats, Floats]:
        """Return the smallest and largest factors, (dimensions,) each."""
        first = space.genes - len(self.dimensions)
        return space.lower[first:], space.upper[first:]

    def initial(self, context: Context) -> State:
        """Return the designs, the known gaits, and the states of the searches of the original."""
        space = _real(context.space)
        designs = designs_of(*self.ends(space), self.levels, self.sample, context.rng)
        starts = context.starts if len(context.starts) else context.random(self.replicates)
        gaits = np.array(starts[:, : -len(self.dimensions)])
        state: dict[str, Any] = {"designs": designs, "genomes": np.empty((0, space.genes))}
        if self.original:
            for replicate in range(self.replicates):
                inner = self._gaits.initial(self._inner(context, len(designs), gaits))
                state |= {f"{replicate}: {name}": value for name, value in inner.items()}
            gaits = np.resize(gaits, (self.replicates, gaits.shape[1]))
        empty = np.empty((0, len(self.reads())))
        known = {"gaits": gaits, "gait scores": np.full(len(gaits), -np.inf)}
        known["gait values"] = np.full((len(gaits), empty.shape[1]), np.nan)
        return {**state, **known, "scores": np.empty(0), "values": empty}

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return gaits of the original, then the known gaits, then variations, for each design."""
        designs, transferred = state["designs"], context.generation - self.original - 1
        if transferred < 0:
            return self._ask_gaits(state, last, context)
        if transferred < self.transfers(len(state["gaits"])):
            chosen = np.arange(self.replicates) + self.replicates * transferred
            gaits = state["gaits"][chosen % len(state["gaits"])].repeat(len(designs), axis=0)
        else:
            gaits = self._varied(state, context)
        genomes = np.concatenate([gaits, np.tile(designs, (self.replicates, 1))], axis=1)
        return context.repair(genomes), state

    def transfers(self, gaits: int) -> int:
        """Return the number of generations in which all designs try the known gaits."""
        return 1 if self.original else -(-gaits // self.replicates)

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Keep the better gaits."""
        values = self._values(results)
        if context.generation <= self.original:
            return self._tell_gaits(state, results, values, context)
        if not len(state["genomes"]):
            found = results.genomes, results.scores, values
        else:
            better = self._better(results.scores, values, state["scores"], state["values"])
            pairs = zip(
                (results.genomes, results.scores, values),
                (state["genomes"], state["scores"], state["values"]),
                strict=True,
            )
            found = tuple(  # type: ignore[assignment]
                np.where(better if new.ndim == 1 else better[:, None], new, old)
                for new, old in pairs
            )
        return {**state, **dict(zip(("genomes", "scores", "values"), found, strict=True))}

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the number of designs with a gait in any replicate, and the mean score."""
        scores = state["scores"]
        alive = np.isfinite(scores)
        count = alive.reshape(self.replicates, -1).any(axis=0).sum()
        mean = float(scores[alive].mean()) if alive.any() else -np.inf
        return {"designs": float(count), "mean of designs": mean}

    def members(self, state: State) -> Members:
        """Return the best gait of each design that has one."""
        designs, count = state["designs"], len(self.dimensions)
        scores = state["scores"].reshape(self.replicates, -1)
        if not scores.size:
            scores = np.full((1, len(designs)), -np.inf)
        best = self.best(state) if len(state["scores"]) else np.zeros(len(designs), np.int64)
        held = np.flatnonzero(np.isfinite(scores[best, np.arange(len(designs))]))
        rows = best[held] * len(designs) + held
        factors = designs[held]
        axes = [np.unique(designs[:, index]) for index in range(count)]
        is_grid = np.prod([len(axis) for axis in axes]) == len(designs)
        cells = held[:, None]
        if is_grid:
            cells = np.stack(
                [np.searchsorted(*pair) for pair in zip(axes, factors.T, strict=True)], 1
            )
        borders = [_borders(axis) if is_grid else axis[[0, -1]] for axis in axes]
        return Members(
            state["genomes"][rows],
            state["scores"][rows],
            dict(zip(self.dimensions, factors.T.copy(), strict=True)),
            cells.astype(np.int64),
            dict(zip(self.dimensions, borders, strict=True)),
            None if is_grid else designs,
        )

    def best(self, state: State) -> NDArray[np.int64]:
        """Return the replicate with the best gait of each design, (designs,)."""
        scores = state["scores"].reshape(self.replicates, -1)
        reached = self._reached(state["scores"], state["values"]).reshape(scores.shape)
        ahead = np.where(reached == reached.max(axis=0), scores, -np.inf)
        return np.asarray(ahead.argmax(axis=0), np.int64)

    def remembered(self, state: State) -> Genomes | None:
        """Return the gaits of all designs and replicates."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores and measures."""
        scores = np.full(len(state["gaits"]), -np.inf)
        found: dict[str, Any] = {**state, "gait scores": scores}
        if len(results.scores):
            found |= {"scores": results.scores, "values": self._values(results)}
        return found

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit the designs and genes, or ''."""
        space = _real(context.space)
        rows, genes, reads = context.population, space.genes, len(self.reads())
        gaits, low, high = len(state["gaits"]), *self.ends(space)
        designs, full = state["designs"], len(state["scores"])
        shapes = {
            "designs": (rows // self.replicates, len(self.dimensions)),
            "gaits": (gaits, genes - len(self.dimensions)),
            "gait scores": (gaits,),
            "gait values": (gaits, reads),
            "genomes": (full, genes),
            "values": (full, reads),
        }
        for name, shape in shapes.items():
            if state[name].shape != shape:
                return f"its {name} have the shape {state[name].shape}, not {shape}"
        if not ((designs >= low) & (designs <= high)).all():
            return "its designs are outside the ranges of the dimensions"
        gait_space = self._gait_space(space)
        if full not in (0, rows) or not gaits or not gait_space.contains(state["gaits"]):
            return f"it does not have the gaits of {rows} individuals"
        own = state["genomes"][:, shapes["gaits"][1] :].reshape(-1, *designs.shape)
        if full and not (space.contains(state["genomes"]) and (own == designs).all()):
            return "its gaits are of a body with different genes, bounds or designs"
        return ""

    # The gaits of the original

    @property
    def _gaits(self) -> Search:
        found = load_class("search", GAITS)()
        assert isinstance(found, Search)
        return found

    def _gait_space(self, space: GenomeSpace) -> RealSpace:
        """Return the genome space of gaits, without the dimensions."""
        space, count = _real(space), -len(self.dimensions)
        periodic = None if space.periodic is None else space.periodic[:count]
        return RealSpace(
            space.lower[:count], space.upper[:count], space.labels[:count], periodic=periodic
        )

    def _inner(self, context: Context, designs: int, starts: Genomes) -> Context:
        """Return the context of a search of the original, with a random stream of its own."""
        (rng,) = context.rng.spawn(1)
        return Context(
            self._gait_space(context.space), designs, context.generation, rng, starts=starts
        )

    def _parts(self, results: Results, values: Floats) -> list[Results]:
        """Return the results of the gaits of the original in each replicate.

        Gaits that are too slow score less than all others (Deb 2000).
        """
        scores, reached = results.scores.copy(), self._reached(results.scores, values)
        if self.speed:
            fast, alive = reached >= self.speed, np.isfinite(scores)
            worst = scores[fast & alive].min(initial=0.0)
            scores = np.where(alive & ~fast, worst - 1 + reached / self.speed, scores)
        gaits = results.genomes[:, : -len(self.dimensions)]
        split = (np.split(one, self.replicates) for one in (gaits, scores))
        return [Results(*part) for part in zip(*split, strict=True)]

    def _ask_gaits(
        self, state: State, last: Results | None, context: Context
    ) -> tuple[Genomes, State]:
        found, gaits, parts = dict(state), [], [None] * self.replicates
        if last is not None:
            parts = self._parts(last, self._values(last))  # type: ignore[assignment]
        for replicate, part in enumerate(parts):
            starts = context.starts[:, : state["gaits"].shape[1]]
            inner = self._inner(context, len(state["designs"]), starts)
            genomes, after = self._gaits.ask(_part(state, replicate), part, inner)
            found |= {f"{replicate}: {name}": value for name, value in after.items()}
            gaits.append(genomes)
        original = np.ones((context.population, len(self.dimensions)))
        return np.concatenate([np.concatenate(gaits), original], axis=1), found

    def _tell_gaits(
        self, state: State, results: Results, values: Floats, context: Context
    ) -> State:
        found, count = dict(state), len(state["designs"])
        gaits, scores, known = (
            state[name].copy() for name in ("gaits", "gait scores", "gait values")
        )
        reached = self._reached(results.scores, values)
        for replicate, part in enumerate(self._parts(results, values)):
            inner = self._inner(context, count, state["gaits"][:0])
            after = self._gaits.tell(_part(state, replicate), part, inner)
            found |= {f"{replicate}: {name}": value for name, value in after.items()}
            rows = np.arange(replicate * count, (replicate + 1) * count)
            best = rows[np.lexsort((results.scores[rows], reached[rows]))[-1]]
            if self._better(
                results.scores[[best]], values[[best]], scores[[replicate]], known[[replicate]]
            )[0]:
                gaits[replicate] = results.genomes[best, : gaits.shape[1]]
                scores[replicate], known[replicate] = results.scores[best], values[best]
        return {**found, "gaits": gaits, "gait scores": scores, "gait values": known}

    # The gaits of the designs

    def _varied(self, state: State, context: Context) -> Genomes:
        """Return a variation of a gait for each design and replicate, (population, genes).

        Each has its own parent, step size and shifts, all independent.
        """
        count, genes = len(state["designs"]), state["gaits"].shape[1]
        rows = np.arange(context.population)
        other = rows - rows % count + context.rng.integers(count, size=len(rows))
        borrowed = context.rng.random(len(rows)) < FROM_OTHERS
        borrowed |= ~np.isfinite(state["scores"])
        parents = state["genomes"][np.where(borrowed, other, rows), :genes]
        low, high = np.log(STEPS)
        steps = np.exp(context.rng.uniform(low, high, (len(rows), 1)))
        shifts = context.rng.standard_normal(parents.shape)
        return np.asarray(parents + steps * _real(context.space).width[:genes] * shifts)

    def _values(self, results: Results) -> Floats:
        """Return the recorded measures, (population, measures)."""
        names = self.reads()
        if not names:
            return np.empty((len(results.scores), 0))
        return np.stack([results.values[name] for name in names], axis=1)

    def _reached(self, scores: Floats, values: Floats) -> Floats:
        """Return the speeds, at most the one to be reached, (population,); −inf for failures."""
        if not self.speed:
            return np.where(np.isfinite(scores), 0.0, -np.inf)
        speeds = np.minimum(values[:, self.reads().index("speed")], self.speed)
        return np.where(np.isfinite(scores) & np.isfinite(speeds), speeds, -np.inf)

    def _better(
        self, scores: Floats, values: Floats, old_scores: Floats, old_values: Floats
    ) -> NDArray[np.bool_]:
        """Return which gaits are better than other ones, (population,)."""
        reached, before = self._reached(scores, values), self._reached(old_scores, old_values)
        better = (reached > before) | ((reached == before) & (scores > old_scores))
        return np.asarray(better, np.bool_)


def designs_of(
    low: Floats, high: Floats, levels: int, sample: int, rng: np.random.Generator
) -> Floats:
    """Return the factors of designs, (designs, dimensions), the original among them.

    Args:
        low: smallest factors, (dimensions,), at most 1.
        high: largest factors, (dimensions,), at least 1.
        levels: factors of each dimension in a grid.
        sample: number of designs in a Latin hypercube (McKay, Beckman and Conover 1979); 0 for a
            grid.
        rng: only source of randomness.
    """
    original = np.ones((1, len(low)))
    if sample:
        ranks = np.stack([rng.permutation(sample - 1) for _ in low], axis=1)
        points = (ranks + rng.random(ranks.shape)) / max(sample - 1, 1)
        return np.concatenate([original, low + points * (high - low)])
    axes = [np.linspace(least, most, levels) for least, most in zip(low, high, strict=True)]
    found = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(low))
    found[np.abs(found - 1) < 1e-9] = 1.0
    return found if (found == 1).all(axis=1).any() else np.concatenate([original, found])


def _borders(levels: Floats) -> Floats:
    """Return the borders of cells around evenly spaced levels, (levels + 1,)."""
    step = (levels[-1] - levels[0]) / (len(levels) - 1)
    return np.append(levels - step / 2, levels[-1] + step / 2)


def _part(state: State, replicate: int) -> State:
    """Return the state of the search of the original in a replicate."""
    prefix = f"{replicate}: "
    return {
        name.removeprefix(prefix): one for name, one in state.items() if name.startswith(prefix)
    }


def _real(space: GenomeSpace) -> RealSpace:
    assert isinstance(space, RealSpace), "the only space that the search supports"
    return space
