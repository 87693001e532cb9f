"""Run a search by itself, on a function of genomes."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import RealSpace
from gaitsim.contracts.search import Context, Results, Search, State

Score = Callable[[NDArray[Any]], NDArray[np.float64]]


def box(genes: int, lower: float = -5, upper: float = 5, **parts: Any) -> RealSpace:
    """A real space with equal bounds of all genes."""
    labels = tuple(f"gene {index}" for index in range(genes))
    return RealSpace(np.full(genes, float(lower)), np.full(genes, float(upper)), labels, **parts)


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
    """Yield state and results of each generation, without end.

    Args:
        search: the search.
        space: its genomes.
        score: genomes (population, genes) -> scores (population,).
        population: genomes in each generation.
        seed: of the randomness.
        start: genome that the first generation begins from.
        after: generation to continue from, with its state and results.
    """

    def context(generation: int, call: int) -> Context:
        rng = np.random.default_rng([seed, generation, call])
        return Context(space, population, generation, rng, start=start)

    generation, state, last = after or (0, search.initial(context(1, 0)), None)
    while True:
        generation += 1
        genomes, state = search.ask(state, last, context(generation, 1))
        last = Results(genomes, score(genomes))
        state = search.tell(state, last, context(generation, 2))
        yield state, last
