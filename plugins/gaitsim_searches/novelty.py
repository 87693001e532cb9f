"""Novelty search: what has not been seen before is kept, whatever its score."""

from collections.abc import Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from gaitsim.plugin import (
    Context,
    Genomes,
    GenomeSpace,
    Results,
    Search,
    State,
    option,
    parents_of_children,
)
from gaitsim_searches.breeding import START_SHARE
from gaitsim_searches.domination import crowding, front_ranks

MOST = 10_000  # individuals in the archive; the oldest are dropped
_CHUNK = 256  # individuals whose distances are in memory at once
_FARTHEST = 1e100  # largest end of an axis, so that differences are finite

Floats = NDArray[np.float64]


class Novelty(Search):
    """Rewards individuals that behave unlike those seen before.

    Lehman and Stanley 2011, "Abandoning objectives: evolution through the search for novelty
    alone". Novelty is the mean distance to the nearest neighbours, in measures as shares of their
    axes, among parents, children and an archive. Random children enter the archive (Gomes, Mariano
    and Christensen 2015, "Devising effective novelty search algorithms"). With the goal 'both',
    the fronts of high novelty and high score survive (Mouret 2011, "Novelty-based
    multiobjectivization").

    State: `genomes` (survivors, genes) with their `scores` and `values` (survivors, axes);
    `archive` (archived, axes); `axes`, names in UTF-8.
    """

    axes: dict[str, tuple[float, float]] = option(
        ...,
        "measures or terms of the score that describe a behaviour, each with its low and high end",
    )
    goal: Literal["novelty", "both"] = option(
        "novelty", "what survives: 'novelty' alone, or 'both' novelty and score, as fronts"
    )
    neighbours: int = option(15, "number of nearest neighbours", ge=1, le=1_000)
    archived: int = option(
        5, "number of random individuals of each generation that enter the archive", ge=0
    )
    start_share: float = START_SHARE

    portable: ClassVar[bool] = True
    operators: ClassVar[tuple[str, ...]] = ("selection", "crossover", "mutation")
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        if not self.axes:
            raise ValueError("'axes' must name at least one measure, such as { speed = [0, 1] }")
        for name, (low, high) in self.axes.items():
            if max(-low, high) > _FARTHEST:
                raise ValueError(
                    f"the ends of the axis {name!r} must be from {-_FARTHEST:g} to {_FARTHEST:g}"
                )
            if not high - low >= 1 / _FARTHEST:
                raise ValueError(
                    f"the ends of the axis {name!r} must ascend, not {low:g}, {high:g}"
                )
        return self

    def reads(self) -> tuple[str, ...]:
        """Return the names of the axes."""
        return tuple(self.axes)

    def initial(self, context: Context) -> State:
        """Return a state without survivors."""
        none = np.empty((0, len(self.axes)))
        return {
            "genomes": context.space.no_genomes,
            "scores": np.empty(0),
            "values": none,
            "archive": none,
            "axes": self._names,
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return children of the survivors."""
        operators, genomes = context.operators, state["genomes"]
        if operators is None:
            raise ValueError("the search needs operators")
        if not len(genomes):
            return context.begin(self.start_share, operators.mutate), state
        ranks, _ = self._ranks(state["scores"], state["values"], state["archive"])
        parents = operators.parents(-ranks.astype(np.float64), context.population)
        crossed = operators.cross(genomes, parents, context.population)
        context.record_parents(parents_of_children(parents, context.population), crossed)
        return operators.mutate(crossed), state

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Select the survivors from the previous survivors and their children."""
        found = self._values(results)
        genomes = np.concatenate([state["genomes"], results.genomes])
        scores = np.concatenate([state["scores"], results.scores])
        values = np.concatenate([state["values"], found])
        ranks, room = self._ranks(scores, values, state["archive"])
        kept = np.lexsort((-room, ranks))[: context.population]
        able = found[np.isfinite(found).all(axis=1)]
        chosen = context.rng.permutation(len(able))[: self.archived]
        archive = np.concatenate([state["archive"], able[chosen]])[-MOST:]
        return {
            **state,
            "genomes": genomes[kept],
            "scores": scores[kept],
            "values": values[kept],
            "archive": archive,
        }

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the mean novelty of the survivors, and the size of the archive."""
        found = novelty(state["values"], state["archive"], self.neighbours)
        finite = found[np.isfinite(found)]
        mean = float(np.add.reduce(finite) / len(finite)) if len(finite) else 0.0
        return {"novelty": mean, "archive": float(len(state["archive"]))}

    def remembered(self, state: State) -> Genomes | None:
        """Return the survivors."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores and values of the survivors, and an empty archive."""
        values = self._values(results)
        return {**state, "scores": results.scores, "values": values, "archive": values[:0]}

    def mismatch(self, state: State, context: Context) -> str:
        """Return why the survivors do not fit the body or the axes, or ''."""
        names = bytes(state["axes"]).decode(errors="replace").split("\0")
        if names != list(self.axes):
            return f"it has different axes: {', '.join(names)}"
        count, axes = len(state["genomes"]), len(self.axes)
        shapes = {"scores": (count,), "values": (count, axes)}
        if any(state[name].shape != shape for name, shape in shapes.items()):
            return "its survivors have inconsistent arrays"
        if state["archive"].shape[1:] != (axes,):
            return "its archive has another number of axes"
        if count and not context.space.contains(state["genomes"]):
            return "its survivors are of a body with different genes or bounds"
        return ""

    @property
    def _names(self) -> NDArray[np.uint8]:
        return np.frombuffer("\0".join(self.axes).encode(), np.uint8)

    def _values(self, results: Results) -> Floats:
        """Return measures as shares of their axes, (population, axes); NaN for a failed one."""
        columns = [
            (results.values[name] - low) / (high - low) for name, (low, high) in self.axes.items()
        ]
        values = np.stack(columns, axis=1)
        able = np.isfinite(values).all(axis=1) & np.isfinite(results.scores)
        return np.where(able[:, None], values, np.nan)

    def _ranks(
        self, scores: Floats, values: Floats, archive: Floats
    ) -> tuple[NDArray[np.int64], Floats]:
        """Return the rank of each individual, the best first, and what decides between equals."""
        found = novelty(values, archive, self.neighbours)
        if self.goal == "novelty":
            order = np.argsort(-found, kind="stable")
            ranks = np.empty(len(found), np.int64)
            ranks[order] = np.arange(len(found))
            return ranks, found
        able = np.isfinite(found)
        costs = np.where(able[:, None], -np.stack([found, scores], axis=1), np.inf)
        ranks = front_ranks(costs)
        return ranks, crowding(np.where(np.isfinite(costs), costs, 0.0), ranks)


def novelty(values: Floats, archive: Floats, neighbours: int) -> Floats:
    """Return the mean distance of individuals to their nearest neighbours, (individuals,).

    Neighbours are other individuals and the archive; −inf for an individual with NaN, 0 without
    neighbours.

    Args:
        values: behaviours, (individuals, axes).
        archive: behaviours seen before, (archived, axes).
        neighbours: largest number of neighbours.
    """
    others = np.concatenate([values, archive])
    found = np.empty(len(values))
    for first in range(0, len(values), _CHUNK):
        part = slice(first, first + _CHUNK)
        found[part] = _mean_distances(values[part], others, first, neighbours)
    return found


def _mean_distances(values: Floats, others: Floats, first: int, neighbours: int) -> Floats:
    """Return the novelty of the individuals from number `first` among all others."""
    squares = np.zeros((len(values), len(others)))
    for mine, theirs in zip(values.T, others.T, strict=True):
        squares += np.square(mine[:, None] - theirs)
    rows = np.arange(len(values))
    squares[rows, first + rows] = np.nan  # itself
    squares = np.where(np.isnan(squares), np.inf, squares)
    if neighbours < len(others):
        squares = np.partition(squares, neighbours - 1, axis=1)[:, :neighbours]
    near = np.sqrt(np.sort(squares, axis=1))
    total, count = np.zeros(len(values)), np.zeros(len(values))
    for distance in near.T:  # in order, so that the last bit does not depend on the processor
        known = np.isfinite(distance)
        total += np.where(known, distance, 0.0)
        count += known
    return np.where(np.isnan(values).any(axis=1), -np.inf, total / np.maximum(count, 1))
