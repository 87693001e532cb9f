"""Run a search on a function of genomes, without bodies."""

import io
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import RealSpace
from gaitsim.contracts.search import NO_STARTS, Context, Results, Search, State

Score = Callable[[NDArray[Any]], NDArray[np.float64]]


def box(genes: int, lower: float = -5, upper: float = 5, **parts: Any) -> RealSpace:
    """Return a real space with equal bounds for all genes."""
    labels = tuple(f"gene {index}" for index in range(genes))
    return RealSpace(np.full(genes, float(lower)), np.full(genes, float(upper)), labels, **parts)


def saved(state: State) -> State:
    """Write the state to a file, and return it as read from there."""
    file = io.BytesIO()
    np.savez(file, **state)  # type: ignore[arg-type]
    file.seek(0)
    with np.load(file) as arrays:
        return dict(arrays)


def generations(
    search: Search,
    space: RealSpace,
    score: Score,
    population: int,
    *,
    seed: int = 0,
    start: NDArray[np.float64] | None = None,
    after: tuple[int, State, Results] | None = None,
) -> Iterator[tuple[State, Results]]:
    """Yield the state and the results of each generation, endlessly.

    Args:
        search: search to run.
        space: genome space.
        score: function from genomes (population, genes) to scores (population,).
        population: number of genomes in each generation.
        seed: seed of all random draws.
        start: start point, (genes,).
        after: number, state and results of the generation to continue from.
    """

    def context(generation: int, call: int) -> Context:
        rng = np.random.default_rng([seed, generation, call])
        return Context(
            space, population, generation, rng, starts=NO_STARTS if start is None else start[None]
        )

    generation, state, last = after or (0, search.initial(context(1, 0)), None)
    while True:
        generation += 1
        genomes, state = search.ask(state, last, context(generation, 1))
        last = Results(genomes, score(genomes))
        state = search.tell(state, last, context(generation, 2))
        yield state, last
