"""The time of a search without evaluation: ask and tell for 100 genomes with 48 genes.

The search first runs twenty other generations, so that its state is realistic. pycma has
the same bounds and population, and takes turns with gaitsim. For pyribs see archives.py, which has
archives of several sizes.
"""

import importlib.util
from collections.abc import Callable

import numpy as np
from timing import medians, milliseconds, print_figure, print_machine, times

from gaitsim.contracts import RealSpace
from gaitsim.contracts.search import Context, Results, Search
from gaitsim_searches.cma_es import CmaEs
from gaitsim_searches.differential_evolution import DifferentialEvolution
from gaitsim_searches.map_elites import MapElites

POPULATION, GENES, EARLIER, REPEATS = 100, 48, 20, 20
SPACE = RealSpace(np.full(GENES, -1.0), np.full(GENES, 1.0), tuple(map(str, range(GENES))))
AXES = {"even": (-0.5, 0.5), "odd": (-0.5, 0.5)}
SEARCHES: dict[str, tuple[Search, float]] = {
    "cma-es, separable": (CmaEs(covariance="separable"), 0.001),
    "cma-es, full": (CmaEs(), 0.004),
    "differential-evolution": (DifferentialEvolution(), 0.001),
    "map-elites, line": (MapElites(axes=AXES, cells=(50, 50)), 0.001),
    "map-elites, cma-mae": (
        MapElites(axes=AXES, cells=(50, 50), variation="cma-mae", threshold=-1e4),
        0.004,
    ),
}
"""Name -> the search and its time budget, seconds."""


def score(genomes: np.ndarray) -> np.ndarray:
    """Return scores that differ in all directions, (population,)."""
    return -np.sum(np.arange(1, GENES + 1) * (genomes - 0.3) ** 2, axis=1)


def generation(search: Search) -> Callable[[], object]:
    """Return a function that asks and tells one generation, the same at each call."""
    state, last = None, None

    def context(number: int, call: int) -> Context:
        return Context(SPACE, POPULATION, number, np.random.default_rng([number, call]))

    def ask_and_tell(number: int) -> tuple[object, Results]:
        genomes, asked = search.ask(state, last, context(number, 0))
        values = {"even": genomes[:, ::2].mean(1), "odd": genomes[:, 1::2].mean(1)}
        results = Results(genomes, score(genomes), values)
        return search.tell(asked, results, context(number, 1)), results

    state = search.initial(context(0, 0))
    for number in range(EARLIER):
        state, last = ask_and_tell(number)
    return lambda: ask_and_tell(EARLIER)


def pycma(*, separable: bool) -> Callable[[], object]:
    """Return a function that asks and tells pycma's next generation."""
    import cma

    options = {"popsize": POPULATION, "bounds": [-1, 1], "verbose": -9, "CMA_diagonal": separable}
    strategy = cma.CMAEvolutionStrategy(np.zeros(GENES), 0.4, {**options, "seed": 1})

    def ask_and_tell() -> None:
        genomes = strategy.ask()
        strategy.tell(genomes, list(-score(np.array(genomes))))

    for _ in range(EARLIER):
        ask_and_tell()
    return ask_and_tell


def main() -> None:
    """Print the figures."""
    print_machine()
    others = {}
    if importlib.util.find_spec("cma") is not None:
        others = {"pycma, diagonal": pycma(separable=True), "pycma, full": pycma(separable=False)}
    works = [generation(search) for search, _ in SEARCHES.values()]
    taken = medians(*works, *others.values(), repeats=REPEATS)
    for (name, (_, budget)), seconds in zip(SEARCHES.items(), taken, strict=False):
        print_figure(name, milliseconds(seconds), f"budget {milliseconds(budget)}")
    for name, seconds, ours in zip(others, taken[len(works) :], taken, strict=False):
        print_figure(name, milliseconds(seconds), f"{times(seconds / ours)} as long")
    if not others:
        print("pycma is not installed; to compare: pip install -e '.[benchmarks]'")


if __name__ == "__main__":
    main()
