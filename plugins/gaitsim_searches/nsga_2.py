"""NSGA-II: a front of trade-offs between several objectives."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gaitsim.plugin import (
    Context,
    Genomes,
    GenomeSpace,
    Members,
    Parents,
    RealSpace,
    Results,
    Search,
    State,
    option,
    parents_of_children,
)
from gaitsim_searches.breeding import exchange_segment, polynomial, simulated_binary
from gaitsim_searches.domination import crowding, front_ranks, hypervolume

SCORE = "score"
"""Name of the objective that is the score itself, besides terms and measures."""

TRIES = 100
"""Largest number of attempts to breed children with new genomes, as in pymoo."""


class Nsga2(Search):
    """Evolves a front of individuals that no other individual beats in every objective.

    Deb, Pratap, Agarwal and Meyarivan 2002, "A fast and elitist multiobjective genetic algorithm:
    NSGA-II". Parents are the winners of binary tournaments by front, then by crowding. Parents and
    children are sorted into fronts together, and the best fronts survive; the last one keeps its
    least crowded individuals. Children that duplicate an existing genome are replaced by others. A
    failed individual is dominated by all others. The defaults are the same as in pymoo 0.6.

    State: `genomes` (survivors, genes) with their `scores`, `values` (survivors, objectives),
    `ranks` of fronts and `crowding`; `reference` (objectives,), the reference point of the
    hypervolume; `objectives`, names and directions in UTF-8.
    """

    objectives: Annotated[dict[str, Literal["max", "min"]], Field(min_length=2)] = option(
        ..., "two or more terms of the score, measures of the body or 'score', each 'max' or 'min'"
    )
    reference: dict[str, float] = option(
        {},
        "reference point of the hypervolume, a value for every objective; "
        "by default the worst values in the first population",
    )
    crossover_probability: float = option(
        0.9, "probability that two parents are crossed", ge=0, le=1
    )
    crossover_gene_probability: float = option(
        0.5, "probability that a real gene of crossed parents is crossed", ge=0, le=1
    )
    crossover_eta: float = option(
        15.0,
        "distribution index of the crossover of real genes; larger values keep children closer to "
        "their parents",
        ge=0,
        le=1000,
    )
    mutation_probability: float = option(0.9, "probability that a child mutates", ge=0, le=1)
    mutation_gene_probability: float | None = option(
        None, "probability that a gene of a mutating child mutates; by default 1/genes", ge=0, le=1
    )
    mutation_eta: float = option(
        20.0,
        "distribution index of the mutation of real genes; larger values make steps shorter",
        ge=0,
        le=1000,
    )

    portable: ClassVar[bool] = True
    keeps: ClassVar[Literal["", "front", "archive"]] = "front"

    @model_validator(mode="after")
    def _check_reference(self) -> Self:
        if self.reference and set(self.reference) != set(self.objectives):
            raise ValueError(
                f"'reference' has values for {', '.join(self.reference)}; "
                f"expected one for each objective: {', '.join(self.objectives)}"
            )
        return self

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the population is too small, or ''."""
        if population < 4:
            return (
                "'nsga-2' needs a population of at least 4 (two pairs of parents), "
                f"not {population}"
            )
        return ""

    def reads(self) -> tuple[str, ...]:
        """Return the names of the objectives without the score, which results always have."""
        return tuple(name for name in self.objectives if name != SCORE)

    def initial(self, context: Context) -> State:
        """Return a state without survivors and with an unset reference point."""
        count = len(self.objectives)
        return {
            "genomes": np.empty((0, context.space.genes), context.space.dtype),
            "scores": np.empty(0),
            "values": np.empty((0, count)),
            "ranks": np.empty(0, np.int64),
            "crowding": np.empty(0),
            "reference": np.full(count, np.nan),
            "objectives": self._signature(),
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Breed children of the survivors.

        Half of the first generation consists of start points and mutants of them, if there are any;
        the rest is random.
        """
        if len(state["genomes"]):
            return self._children(state, context), state
        return context.begin(0.5, lambda genomes: self._mutants(genomes, context)), state

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Select the survivors from the previous survivors and their children."""
        values = self._values(results)
        return self._survivors(
            np.concatenate([state["genomes"], results.genomes]),
            np.concatenate([state["scores"], results.scores]),
            np.concatenate([state["values"], values]),
            state if np.isfinite(state["reference"]).all() else self._with_reference(state, values),
            context.population,
        )

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the hypervolume and the size of the front."""
        front = state["values"][_on_front(state)]
        reference = np.array([self.reference[name] for name in self.objectives if self.reference])
        if not len(reference):
            reference = state["reference"]
        volume = hypervolume(self._costs(front), self._costs(reference)) if len(front) else 0.0
        return {"hypervolume": volume, "front size": float(len(front))}

    def members(self, state: State) -> Members | None:
        """Return the front, sorted by the first objective."""
        front = np.flatnonzero(_on_front(state))
        front = front[np.lexsort(state["values"][front].T[::-1])]
        values = state["values"][front].T
        return Members(
            state["genomes"][front],
            state["scores"][front],
            dict(zip(self.objectives, values, strict=True)),
        )

    def remembered(self, state: State) -> Genomes | None:
        """Return the survivors."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Sort the survivors by new values; the reference point may become worse."""
        values = self._values(results)
        state = self._with_reference(state, values)
        return self._survivors(results.genomes, results.scores, values, state, len(results.genomes))

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state has different objectives or an array of the wrong shape, or ''."""
        expected, found = self._signature(), state["objectives"]
        if np.array_equal(expected, found):
            count = len(state["genomes"])
            shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
                ("scores", "ranks", "crowding"), (count,)
            )
            shapes["genomes"] = (count, context.space.genes)
            shapes["values"] = (count, len(self.objectives))
            shapes["reference"] = (len(self.objectives),)
            wrong = [name for name, shape in shapes.items() if state[name].shape != shape]
            return f"its array {wrong[0]!r} has shape {state[wrong[0]].shape}" if wrong else ""
        names = bytes(found.astype(np.uint8)).decode(errors="replace").split("\n")
        return (
            f"its objectives are {', '.join(names)}, "
            f"not {', '.join(bytes(expected).decode().split(chr(10)))}"
        )

    def _children(self, state: State, context: Context) -> Genomes:
        """Breed until enough children differ from the survivors and from each other."""
        wanted, tries = context.population, 0
        children = crossed = state["genomes"][:0]
        parents = np.empty((0, 2), np.int64)
        while len(children) < wanted and tries < TRIES:
            tries += 1
            bred, before, theirs = self._breed(state, wanted - len(children), context)
            new = _are_new(np.concatenate([state["genomes"], children]), bred)
            children = np.concatenate([children, bred[new]])
            crossed = np.concatenate([crossed, before[new]])
            parents = np.concatenate([parents, theirs[new]])
        if missing := wanted - len(children):  # nearly all genomes of the space exist already
            children = np.concatenate([children, context.random(missing)])
            crossed = np.concatenate([crossed, children[-missing:]])
            parents = np.concatenate([parents, np.full((missing, 2), -1)])
        context.record_parents(parents, crossed)
        return children

    def _breed(
        self, state: State, count: int, context: Context
    ) -> tuple[Genomes, Genomes, Parents]:
        """Return `count` repaired children, what they were before mutation, and their parents."""
        space, rng = context.space, context.rng
        pairs = -(-count // 2)
        chosen = _tournaments(state, 2 * pairs, rng).reshape(2, pairs)
        parents = state["genomes"][chosen]
        crossed = rng.random(pairs) < self.crossover_probability
        if isinstance(space, RealSpace):
            genes = rng.random(parents.shape[1:]) < self.crossover_gene_probability
            crossed = crossed[:, None] & genes
            children = simulated_binary(parents, crossed, self.crossover_eta, space, rng)
            children = context.repair(children.reshape(-1, space.genes))
        else:
            children = exchange_segment(parents, crossed, rng).reshape(-1, space.genes)
        mutants = context.repair(self._mutants(children[:count], context))
        return mutants, children[:count], parents_of_children(chosen.T, count)

    def _mutants(self, genomes: Genomes, context: Context) -> Genomes:
        """Mutate genes at random; the genomes must be repaired afterwards."""
        space, rng = context.space, context.rng
        rate = self.mutation_gene_probability
        rate = min(0.5, 1 / space.genes) if rate is None else rate
        mutated = rng.random((len(genomes), 1)) < self.mutation_probability
        mutated = mutated & (rng.random(genomes.shape) < rate)
        if isinstance(space, RealSpace):
            return polynomial(genomes, mutated, self.mutation_eta, space, rng)
        return genomes ^ mutated

    def _values(self, results: Results) -> NDArray[np.float64]:
        """Return the values of the objectives, (individuals, objectives).

        All are NaN for a failed individual, or one with a value that is not finite.
        """
        columns = [
            results.scores if name == SCORE else results.values[name] for name in self.objectives
        ]
        values = np.stack(columns, axis=-1)
        failed = ~(np.isfinite(values).all(axis=1) & np.isfinite(results.scores))
        return np.where(failed[:, None], np.nan, values)

    def _costs(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the costs to minimise; ∞ for a failed individual."""
        signs = [1.0 if direction == "min" else -1.0 for direction in self.objectives.values()]
        costs = values * signs
        return np.where(np.isnan(costs), np.inf, costs)

    def _with_reference(self, state: State, values: NDArray[np.float64]) -> State:
        """Return the state with a reference point at least as bad as all of these values."""
        known = np.concatenate([state["reference"][None], values])
        known = known[np.isfinite(known).all(axis=1)]
        if not len(known):
            return state
        worst = self._costs(known).argmax(axis=0)
        return {**state, "reference": known[worst, np.arange(len(worst))]}

    def _survivors(
        self,
        genomes: Genomes,
        scores: NDArray[np.float64],
        values: NDArray[np.float64],
        state: State,
        count: int,
    ) -> State:
        """Return the state with the best `count` individuals, by front, then by crowding."""
        costs = self._costs(values)
        ranks = front_ranks(costs)
        room = crowding(np.where(np.isfinite(costs), costs, 0.0), ranks)
        best = np.lexsort((-room, ranks))[:count]
        return {
            **state,
            "genomes": genomes[best],
            "scores": scores[best],
            "values": values[best],
            "ranks": ranks[best],
            "crowding": room[best],
        }

    def _signature(self) -> NDArray[np.uint8]:
        text = "\n".join(f"{name}: {direction}" for name, direction in self.objectives.items())
        return np.frombuffer(text.encode(), np.uint8)


def _on_front(state: State) -> NDArray[np.bool_]:
    """Return whether each survivor is on the first front and did not fail, (survivors,)."""
    first: NDArray[np.bool_] = state["ranks"] == 0
    first &= np.isfinite(state["values"]).all(axis=1)
    return first


def _tournaments(state: State, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the winners of binary tournaments by front, then by crowding, (count,).

    The numbers of tournaments that two survivors enter differ by at most one. Ties are decided at
    random.
    """
    ranks, room = state["ranks"], state["crowding"]
    rounds = -(-2 * count // len(ranks))
    order = np.tile(np.arange(len(ranks)), (rounds, 1))
    one, other = rng.permuted(order, axis=1).reshape(-1)[: 2 * count].reshape(-1, 2).T
    better = (ranks[other] < ranks[one]) | (
        (ranks[other] == ranks[one]) & (room[other] > room[one])
    )
    return np.where(better, other, one)


def _are_new(known: Genomes, genomes: Genomes) -> NDArray[np.bool_]:
    """Return whether each genome is neither known nor equal to an earlier one, (genomes,)."""
    rows = np.ascontiguousarray(np.concatenate([known, genomes]))
    keys = rows.view(np.dtype((np.void, rows.strides[0]))).reshape(-1)
    first = np.zeros(len(rows), np.bool_)
    first[np.unique(keys, return_index=True)[1]] = True
    return first[len(known) :]
