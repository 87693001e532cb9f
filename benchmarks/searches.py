"""The time of a search without evaluation: ask and tell for 100 genomes with 48 genes.

The search first runs twenty other generations, so that its state is realistic. pycma has
the same bounds and population, and takes turns with gaitsim. For pyribs see archives.py, which has
archives of several sizes. The second table is for a cheap function, the sphere with 10 genes: the
processor time per evaluation of 50 generations, all included, in gaitsim, pycma and cmaes.
"""

import importlib.util
import time
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


CHEAP_GENES, CHEAP_GENERATIONS = 10, 50


def cheap_gaitsim(population: int) -> None:
    """Minimise the sphere with gaitsim."""
    side = np.full(CHEAP_GENES, 5.0)
    space = RealSpace(-side, side, tuple(map(str, range(CHEAP_GENES))))

    def context(number: int, call: int) -> Context:
        return Context(space, population, number, np.random.default_rng([number, call]))

    search, last = CmaEs(), None
    state = search.initial(context(1, 0))
    for number in range(1, CHEAP_GENERATIONS + 1):
        genomes, state = search.ask(state, last, context(number, 1))
        last = Results(genomes, -np.sum(np.square(genomes - 1), axis=1))
        state = search.tell(state, last, context(number, 2))


def cheap_pycma(population: int) -> None:
    """Minimise the sphere with pycma."""
    import cma

    options = {"popsize": population, "bounds": [-5, 5], "verbose": -9, "seed": 1}
    strategy = cma.CMAEvolutionStrategy(np.zeros(CHEAP_GENES), 2, options)
    for _ in range(CHEAP_GENERATIONS):
        points = strategy.ask()
        strategy.tell(points, list(np.sum(np.square(np.array(points) - 1), axis=1)))


def cheap_cmaes(population: int) -> None:
    """Minimise the sphere with cmaes."""
    import cmaes

    bounds = np.tile([-5.0, 5.0], (CHEAP_GENES, 1))
    strategy = cmaes.CMA(
        np.zeros(CHEAP_GENES), 2.0, bounds=bounds, population_size=population, seed=1
    )
    for _ in range(CHEAP_GENERATIONS):
        points = [strategy.ask() for _ in range(population)]
        strategy.tell([(point, float(np.sum(np.square(point - 1)))) for point in points])


CHEAP = {"gaitsim": cheap_gaitsim, "cma": cheap_pycma, "cmaes": cheap_cmaes}
"""Module -> function that minimises the sphere with a population."""


def print_cheap() -> None:
    """Print the processor time per evaluation of the sphere, the minimum of ten repeats."""
    installed = [name for name in CHEAP if importlib.util.find_spec(name) is not None]
    for population in (10, 100):
        taken: dict[str, list[float]] = {name: [] for name in installed}
        for _ in range(10):  # the programs take turns
            for name, seconds in taken.items():
                start = time.process_time()
                CHEAP[name](population)
                seconds.append(time.process_time() - start)
        for name, seconds in taken.items():
            each = 1e6 * min(seconds) / (CHEAP_GENERATIONS * population)
            print_figure(f"sphere, population {population}, {name}", f"{each:.3g} µs")


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
    print_cheap()


if __name__ == "__main__":
    main()
