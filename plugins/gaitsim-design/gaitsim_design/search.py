"""The search `designs`: the best gaits of many designs of a body, in independent replicates.

The last genes of a genome are factors of the body's dimensions. A run has three phases:

    original: CMA-ES evolves gaits of the original  ─▶  transfer: every design tries the best
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

MOST = 100_000
"""Maximum number of designs."""

FROM_OTHERS = 0.5
"""Share of the variations whose parent is the gait of another design."""

STEPS = 0.002, 0.2
"""Ends of the step sizes, as shares of the range of each gene; their logarithms are uniform."""


class Designs(Search):
    """Keeps the best gait of each of many designs of a body, in independent replicates.

    A design keeps the better of its gait and a variation of it, as the (1 + 1) evolution strategy
    of Rechenberg 1973 does; instead of adapting, step sizes are drawn from a wide range. Half of
    the parents are gaits of other designs, as in MAP-Elites (Mouret and Clune 2015): the better one
    of two.
    """

    dimensions: tuple[str, ...] = option(
        (), "names of the dimensions, whose factors are the last genes"
    )
    levels: int = option(7, "factors of each dimension in a grid of designs", ge=3, le=1000)
    sample: int = option(
        0,
        "number of designs, the original among them, in a Latin hypercube instead of a grid",
        ge=0,
        le=MOST,
    )
    replicates: int = option(
        3, "independent repetitions, whose differences show the noise of the search", ge=1, le=1000
    )
    original: int = option(
        10, "generations that evolve gaits of the original; 0 begins with known gaits", ge=0
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
        count = len(self.dimensions)
        if not (isinstance(space, RealSpace) and 0 < count < space.genes):
            return f"{space.genes} genes are too few for {count} dimensions and a gait"
        if self.sample == 1 or (not self.sample and self.levels**count >= MOST):
            return f"the number of designs must be from 2 to {MOST:,}"
        ends = self.ends(space)
        for name, low, high in zip(self.dimensions, *ends, strict=True):
            if not low <= 1 <= high:
                return f"the range of {name}, {low:g} to {high:g}, must contain the original, 1"
        designs = len(designs_of(*ends, self.levels, self.sample, np.random.default_rng(0)))
        if population == designs * self.replicates:
            return ""
        return (
            f"the population must be {designs * self.replicates}: {designs} designs in "
            f"{self.replicates} replicates"
        )

    def reads(self) -> tuple[str, ...]:
        """Return the names of the recorded measures, and the speed if one is to be reached."""
        return tuple(dict.fromkeys((*self.measures, *(["speed"] if self.speed else []))))

    def ends(self, space: GenomeSpace) -> tuple[Floats, Floats]:
        """Return the smallest and largest factors, (dimensions,) each."""
        assert isinstance(space, RealSpace), "the only space that the search supports"
        first = space.genes - len(self.dimensions)
        return space.lower[first:], space.upper[first:]

    def initial(self, context: Context) -> State:
        """Return the designs and the known gaits."""
        known = context.starts if len(context.starts) else context.random(context.population)
        inner: dict[str, Any] = {}
        for replicate in range(self.replicates if self.original else 0):
            states = self._gaits.initial(self._inner(context, context.starts))
            inner |= {f"{replicate}: {name}": one for name, one in states.items()}
        return {
            **inner,
            "designs": designs_of(*self.ends(context.space), self.levels, self.sample, context.rng),
            "known": np.array(known[:, : -len(self.dimensions)]),
            "genomes": np.empty((0, context.space.genes)),
            "scores": np.empty(0),
            "values": np.empty((0, len(self.reads()))),
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return gaits of the original, then of all designs: known ones, then variations."""
        designs, known = state["designs"], state["known"]
        rows, count, genes = np.arange(context.population), len(designs), known.shape[1]
        begun = context.generation - self.original - 1  # generations of all designs so far
        if begun < 0:
            gaits, state = self._ask_gaits(state, last, context)
        elif begun == 0 and self.original:
            leading = self._lead(state).argmin(axis=1) + count * np.arange(self.replicates)
            gaits = state["genomes"][leading, :genes].repeat(count, axis=0)
        elif 0 <= begun < self.transfers(len(known)):
            gaits = known[(rows // count + self.replicates * begun) % len(known)]
        else:
            gaits = self._parents(state, context)[:, :genes] + self._shifts(context, genes)
        factors = np.ones_like(designs) if begun < 0 else designs
        genomes = np.concatenate([gaits, np.tile(factors, (self.replicates, 1))], axis=1)
        return context.repair(genomes), state

    def transfers(self, known: int) -> int:
        """Return the number of generations in which all designs try gaits of the original."""
        return 1 if self.original else -(-known // self.replicates)

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Keep the better gaits; the first gaits of the designs replace those of the original."""
        if context.generation <= self.original:
            state = self._tell_gaits(state, results, context)
        found = {
            "genomes": results.genomes,
            "scores": results.scores,
            "values": self._values(results),
        }
        if len(state["genomes"]) and context.generation != self.original + 1:
            reached, before = (
                self._reached(one["scores"], one["values"]) for one in (found, state)
            )
            better = found["scores"] > state["scores"]
            better = (reached > before) | ((reached == before) & better)
            for name, new in found.items():
                chosen = better if new.ndim == 1 else better[:, None]
                found[name] = np.where(chosen, new, state[name])
        return {**state, **found}

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the number of designs with a gait in any replicate, and the mean score."""
        alive = np.isfinite(state["scores"])
        count = alive.reshape(self.replicates, -1).any(axis=0).sum()
        mean = float(state["scores"][alive].mean()) if alive.any() else -np.inf
        return {"designs": float(count), "mean of designs": mean}

    def has_designs(self, state: State) -> bool:
        """Return whether gaits of the designs are known, and not only those of the original."""
        genomes = state["genomes"]
        own = genomes[:, genomes.shape[1] - len(self.dimensions) :]
        return len(own) > 0 and np.array_equal(own[: len(state["designs"])], state["designs"])

    def best(self, state: State) -> NDArray[np.int64]:
        """Return the replicate with the best gait of each design, (designs,)."""
        return np.asarray(self._lead(state).argmin(axis=0), np.int64)

    def members(self, state: State) -> Members:
        """Return the best gait of each design that has one."""
        designs, rows = state["designs"], np.empty(0, np.int64)
        if self.has_designs(state):
            rows = self.best(state) * len(designs) + np.arange(len(designs))
            rows = rows[np.isfinite(state["scores"][rows])]
        held = rows % len(designs)
        axes = [np.unique(one) for one in designs.T]
        cells, borders = held[:, None], [one[[0, -1]] for one in axes]
        centres: Floats | None = designs
        if np.prod([len(one) for one in axes]) == len(designs):  # a grid
            pairs = zip(axes, designs[held].T, strict=True)
            cells = np.stack([np.searchsorted(*pair) for pair in pairs], axis=1)
            borders, centres = [_borders(one) for one in axes], None
        return Members(
            state["genomes"][rows],
            state["scores"][rows],
            dict(zip(self.dimensions, designs[held].T.copy(), strict=True)),
            cells.astype(np.int64),
            dict(zip(self.dimensions, borders, strict=True)),
            centres,
        )

    def remembered(self, state: State) -> Genomes | None:
        """Return the gaits of all designs and replicates."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores and measures."""
        if not len(results.scores):
            return state
        return {**state, "scores": results.scores, "values": self._values(results)}

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit the designs and genes, or ''."""
        rows, genes, count = context.population, context.space.genes, len(self.dimensions)
        full, known = len(state["scores"]), len(state["known"])
        designs, (low, high) = state["designs"], self.ends(context.space)
        shapes = {
            "designs": (rows // self.replicates, count),
            "known": (known, genes - count),
            "genomes": (full, genes),
            "values": (full, len(self.reads())),
        }
        for name, shape in shapes.items():
            if state[name].shape != shape:
                return f"its {name} have the shape {state[name].shape}, not {shape}"
        if not ((designs >= low) & (designs <= high)).all() or not (designs == 1).all(axis=1).any():
            return "its designs are not those of the dimensions and their ranges"
        genomes = np.concatenate([np.c_[state["known"], np.ones((known, count))], state["genomes"]])
        if full not in (0, rows) or not known or not context.space.contains(genomes):
            return "its gaits are of a body with different genes or bounds"
        factors = np.tile(designs, (self.replicates, 1)) if self.has_designs(state) else 1.0
        if not (state["genomes"][:, genes - count :] == factors).all():
            return "its gaits are of other designs"
        inner = self._inner(context, context.starts) if self.original else context
        parts = (_part(state, one) for one in range(self.replicates if self.original else 0))
        return next(filter(None, (self._gaits.mismatch(one, inner) for one in parts)), "")

    @property
    def _gaits(self) -> Search:
        """The search for gaits of the original."""
        found = load_class("search", "cma-es")()
        assert isinstance(found, Search), "its contract"
        return found

    def _inner(self, context: Context, starts: Genomes) -> Context:
        """Return the context of a search for gaits of the original, with its own random stream."""
        space, count = context.space, -len(self.dimensions)
        assert isinstance(space, RealSpace), "the only space that the search supports"
        periodic = None if space.periodic is None else space.periodic[:count]
        gaits = RealSpace(
            space.lower[:count], space.upper[:count], space.labels[:count], periodic=periodic
        )
        (rng,) = context.rng.spawn(1)
        population = context.population // self.replicates
        return Context(gaits, population, context.generation, rng, starts=starts[:, :count])

    def _split(self, results: Results) -> list[Results]:
        """Return gaits and scores of each replicate; slow gaits score below others (Deb 2000)."""
        scores, reached = results.scores, self._reached(results.scores, self._values(results))
        if self.speed:
            slow = np.isfinite(scores) & (reached < self.speed)
            worst = scores[reached == self.speed].min(initial=0.0)
            scores = np.where(slow, worst - 1 + reached / self.speed, scores)
        gaits = results.genomes[:, : -len(self.dimensions)]
        split = (np.split(one, self.replicates) for one in (gaits, scores))
        return [Results(*part) for part in zip(*split, strict=True)]

    def _ask_gaits(
        self, state: State, last: Results | None, context: Context
    ) -> tuple[Genomes, State]:
        """Return gaits of the original, (population, genes), and the state for `tell`."""
        parts = [None] * self.replicates if last is None else self._split(last)
        gaits, found = [], dict(state)
        for replicate, part in enumerate(parts):
            inner = self._inner(context, context.starts)
            genomes, after = self._gaits.ask(_part(state, replicate), part, inner)
            found |= {f"{replicate}: {name}": one for name, one in after.items()}
            gaits.append(genomes)
        return np.concatenate(gaits), found

    def _tell_gaits(self, state: State, results: Results, context: Context) -> State:
        """Return the state with the searches for gaits of the original updated."""
        found = dict(state)
        for replicate, part in enumerate(self._split(results)):
            inner = self._inner(context, context.starts)
            after = self._gaits.tell(_part(state, replicate), part, inner)
            found |= {f"{replicate}: {name}": one for name, one in after.items()}
        return found

    def _parents(self, state: State, context: Context) -> Genomes:
        """Return a gait to vary for each design and replicate, (population, genes)."""
        count, rows = len(state["designs"]), np.arange(context.population)
        pair = rows - rows % count + context.rng.integers(count, size=(2, len(rows)))
        lead = self._lead(state).ravel()
        other = np.where(lead[pair[0]] < lead[pair[1]], *pair)
        borrowed = context.rng.random(len(rows)) < FROM_OTHERS
        borrowed |= ~np.isfinite(state["scores"])
        return np.asarray(state["genomes"][np.where(borrowed, other, rows)])

    def _shifts(self, context: Context, genes: int) -> Floats:
        """Return normal shifts of the genes, (population, genes), each row with its step size."""
        assert isinstance(context.space, RealSpace), "the only space that the search supports"
        low, high = np.log(STEPS)
        steps = np.exp(context.rng.uniform(low, high, (context.population, 1)))
        normal = context.rng.standard_normal((context.population, genes))
        return np.asarray(steps * context.space.width[:genes] * normal)

    def _lead(self, state: State) -> NDArray[np.int64]:
        """Return the rank of each gait among all, (replicates, designs); 0 is the best."""
        reached = self._reached(state["scores"], state["values"])
        ranks = np.empty(len(reached), np.int64)
        ranks[np.lexsort((state["scores"], reached))[::-1]] = np.arange(len(reached))
        return ranks.reshape(self.replicates, -1)

    def _values(self, results: Results) -> Floats:
        """Return the recorded measures, (population, measures)."""
        if not self.reads():
            return np.empty((len(results.scores), 0))
        return np.stack([results.values[name] for name in self.reads()], axis=1)

    def _reached(self, scores: Floats, values: Floats) -> Floats:
        """Return the speeds, at most the one to be reached, (population,); −inf for failures."""
        if not self.speed:
            return np.where(np.isfinite(scores), 0.0, -np.inf)
        speeds = np.minimum(values[:, self.reads().index("speed")], self.speed)
        return np.where(np.isfinite(scores) & np.isfinite(speeds), speeds, -np.inf)


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


def _part(state: State, replicate: int) -> State:
    """Return the state of the search for gaits of the original in a replicate."""
    prefix = f"{replicate}: "
    return {
        name.removeprefix(prefix): one for name, one in state.items() if name.startswith(prefix)
    }


def _borders(levels: Floats) -> Floats:
    """Return the borders of cells around evenly spaced levels, (levels + 1,)."""
    step = (levels[-1] - levels[0]) / (len(levels) - 1)
    return np.append(levels - step / 2, levels[-1] + step / 2)
