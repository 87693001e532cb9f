"""Trials of searches and reflexes without a body, with artificial scores and observations."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    OBSERVATIONS,
    Context,
    Floats,
    Genomes,
    GenomeSpace,
    Inputs,
    Legs,
    Observation,
    Plugin,
    RealSpace,
    Reflex,
    Results,
    Search,
    State,
)

PLACEHOLDERS: Mapping[str, object] = {
    "objectives": {"score": "max", "first": "min"},
    "axes": {"first": [0.0, 1.0], "second": [0.0, 2.0]},
}
"""Values for required options that name measures, because trials run without a body."""

GENERATIONS = 8  # number of generations in a trial run
POPULATIONS = (12, 16, 100)  # the first size that the search supports is used
CASES = ("random scores", "half of them −inf", "all of them −inf", "equal scores", "huge scores")


def with_placeholders(model: type[Plugin], options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options, with placeholders for required options that name measures."""
    if not issubclass(model, Search):
        return dict(options)
    required = (name for name, field in model.model_fields.items() if field.is_required())
    return {name: PLACEHOLDERS[name] for name in required if name in PLACEHOLDERS} | dict(options)


def build_plugin(model: type[Plugin], values: Mapping[str, Any]) -> Plugin:
    """Return a plugin with options, validated as in an experiment file."""
    return model.model_validate_json(json.dumps(values), strict=True)


@dataclass(frozen=True)
class _Operators:
    """Substitutes for the operators of an experiment; see `gaitsim.contracts.Operators`."""

    space: GenomeSpace
    rng: np.random.Generator

    def parents(self, scores: NDArray[np.float64], children: int) -> NDArray[np.intp]:
        shape = (*scores.shape[:-1], children, 2)
        return self.rng.integers(scores.shape[-1], size=shape, dtype=np.intp)

    def cross(self, genomes: Genomes, parents: NDArray[np.intp], children: int) -> Genomes:
        mothers, fathers = (
            np.take_along_axis(genomes, parents[..., side, None], axis=-2) for side in (0, 1)
        )
        return np.where(self.rng.random(mothers.shape) < 0.5, mothers, fathers)

    def mutate(self, genomes: Genomes) -> Genomes:
        fresh = self.space.random(genomes[..., 0].size, self.rng).reshape(genomes.shape)
        mutated = np.where(self.rng.random(genomes.shape) < 0.1, fresh, genomes)
        return self.space.repair(mutated.reshape(-1, self.space.genes)).reshape(genomes.shape)


@dataclass(frozen=True)
class SearchTrial:
    """A search in one genome space, with one kind of scores.

    Attributes:
        search: search to test.
        space: genome space.
        population: number of genomes in each generation.
        case: kind of scores, one of `CASES`.
        initial_state: state before the first generation; None calls `Search.initial`.
    """

    search: Search
    space: GenomeSpace
    population: int
    case: str = CASES[0]
    initial_state: State | None = None

    def context(self, generation: int, call: int, **parts: Any) -> Context:
        """Return the context of a call: 0 is `initial`, 1 `ask`, 2 `tell`, 3 any other method."""
        rng = np.random.default_rng([5, generation, call])
        operators = None
        if self.search.operators:
            operators = _Operators(self.space, np.random.default_rng([6, generation]))
        return Context(self.space, self.population, generation, rng, operators=operators, **parts)

    def initial(self) -> State:
        """Return a copy of `initial_state`, or a new initial state if it is None."""
        if self.initial_state is None:
            return self.search.initial(self.context(1, 0))
        return {name: values.copy() for name, values in self.initial_state.items()}

    def evaluate(self, genomes: Genomes, generation: int) -> Results:
        """Return genomes with artificial scores, and values for all names that the search reads."""
        shares = genomes.astype(np.float64)
        if isinstance(self.space, RealSpace):
            shares = (genomes - self.space.lower) / self.space.width
        scores = -np.sum((shares - 0.3) ** 2, axis=-1)
        failed = np.zeros(scores.shape, bool)
        match self.case:
            case "half of them −inf":
                failed[..., generation % 2 :: 2] = True
            case "all of them −inf":
                failed[...] = True
            case "equal scores":
                scores[...] = 1.0
            case "huge scores":
                scores *= 1e99
        values = {
            name: np.where(failed, np.nan, shares[..., number % self.space.genes] * (number + 1))
            for number, name in enumerate(self.search.reads())
        }
        return Results(genomes, np.where(failed, -np.inf, scores), values)

    def run(
        self, generations: int, state: Any = None, last: Results | None = None, done: int = 0
    ) -> Iterator[tuple[Any, Results]]:
        """Yield the state and results of each generation after the first `done` generations."""
        state = self.initial() if state is None else state
        for generation in range(done + 1, generations + 1):
            genomes, state = self.search.ask(state, last, self.context(generation, 1))
            last = self.evaluate(genomes, generation)
            state = self.search.tell(state, last, self.context(generation, 2))
            yield state, last


def result_arrays(results: Results | None) -> list[Any]:
    """Return the arrays of results, for comparison; [] for None."""
    return [] if results is None else [results.genomes, results.scores, dict(results.values)]


def make_trial(search: Search, space: GenomeSpace) -> SearchTrial | None:
    """Return a trial with the first supported population size; None if none is supported."""
    supported = (size for size in POPULATIONS if not search.objection(space, size))
    return next((SearchTrial(search, space, size) for size in supported), None)


INDIVIDUALS = 5
STEPS = 50
INTERVAL = 0.02  # s
LEGS = {
    "four legs": Legs(
        ("FL", "FR", "HL", "HR"),
        np.array([[0.1, 0.08], [0.1, -0.08], [-0.1, 0.08], [-0.1, -0.08]]),
        0.15,
        12,
    ),
    "two legs": Legs(("L", "R"), np.array([[0.0, 0.05], [0.0, -0.05]]), 0.4, 10),
}
"""The legs on which reflexes are tried."""


def _observe(legs: Legs, needs: tuple[str, ...], step: int) -> Observation:
    """Return random observations of a population; those that the reflex does not need are NaN."""
    rng = np.random.default_rng([3, step])
    shape = (INDIVIDUALS, len(legs.names))
    walking = np.where(rng.random((INDIVIDUALS, 1)) < 0.8, 1.0, 0.0)
    seen = Observation(
        orientation=rng.normal(size=(INDIVIDUALS, 3)),
        rates=rng.normal(size=(INDIVIDUALS, 3)),
        contacts=rng.integers(2, size=shape).astype(np.float64),
        load=rng.random(shape),
        joints=rng.normal(size=(INDIVIDUALS, legs.joints)),
        command=walking * rng.normal(size=(INDIVIDUALS, 4)),
        heading=rng.normal(size=INDIVIDUALS),
        phase=rng.random(shape),
        duty=0.3 + 0.5 * rng.random((INDIVIDUALS, 1)),
    )
    for name in {*OBSERVATIONS} - {*needs}:
        getattr(seen, name)[:] = np.nan
    return seen


@dataclass
class ReflexTrial:
    """A reflex on random observations.

    Attributes:
        reflex: reflex to try.
        legs: legs of the body.
        rows: individuals of the population that take part.
    """

    reflex: Reflex
    legs: Legs
    rows: range = range(INDIVIDUALS)

    def start(self) -> Any:
        """Return the state at the start."""
        rng = np.random.default_rng(1)
        genes: Floats = 2 * rng.random((INDIVIDUALS, self.reflex.weights(self.legs))) - 1
        return self.reflex.start(self.legs, genes[self.rows].copy())

    def observe(self, step: int) -> Observation:
        """Return the observations of a step."""
        seen = _observe(self.legs, self.reflex.needs, step)
        return Observation(**{name: values[self.rows] for name, values in fields_of(seen).items()})

    def run(self, steps: int = STEPS) -> dict[str, Any]:
        """Return the inputs after each step, and the state at the end, by name."""
        state = self.start()
        found: dict[str, Any] = {}
        for step in range(steps):
            seen = self.observe(step)
            inputs = Inputs.unchanged(seen.command, len(self.legs.names))
            self.reflex.step(state, seen, inputs, INTERVAL)
            found |= {f"{name} of step {step}": value for name, value in fields_of(inputs).items()}
        return found | {f"state {name!r}": values for name, values in state.items()}


def fields_of(values: Observation | Inputs) -> dict[str, Floats]:
    """Return the arrays of observations or inputs, by name."""
    return {field.name: getattr(values, field.name) for field in fields(values)}
