"""MAP-Elites on pyribs' 100-dimensional sphere, compared with the figures published by pyribs.

Linear projection of Fontaine et al. 2020: 10,000 iterations of 540 genomes, a grid of 100 × 100,
step sizes of 0.5 and a start at 0, as in pyribs' `examples/sphere.py`. Genes have no bounds there;
here the bounds are too wide to matter. A run takes one minute, or ten with emitters.

pyribs multiplies the rank-one update of the covariance by its learning rate twice, which makes the
update negligible. The last rows reproduce this.

    python benchmarks/archives.py [--seeds 3] [--iterations 10000] [--only line]
"""

import argparse
import importlib.util
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from itertools import count
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from timing import milliseconds, print_figure, print_machine, times

from gaitsim.contracts import Context, RealSpace, Results, State
from gaitsim_searches import emitters
from gaitsim_searches.map_elites import MapElites

GENES = 100
BOUND = 5.12
POPULATION = 540
WIDTH = 1_000.0
STEP = 0.5 / WIDTH
REACH = GENES / 2 * BOUND
VARIATIONS: dict[str, dict[str, Any]] = {
    "isotropic": {"sigma": STEP},
    "line": {"sigma": STEP, "line_sigma": 0.2},
    "cma-me": {"step": STEP, "emitters": 15},
    "cma-mae": {"step": STEP, "emitters": 15, "learning_rate": 0.01, "threshold": 0.0},
}
AS_PYRIBS = ", as pyribs"
# pyribs 0.12, docs/examples/sphere.md: mean and standard deviation of 20 trials.
PUBLISHED = {
    "isotropic": ((50.72, 0.40), (416_112, 2_681)),
    "line": ((60.44, 0.17), (491_014, 1_119)),
    "cma-me": ((55.84, 0.41), (456_678, 2_882)),
    "cma-mae": ((81.02, 0.27), (633_369, 1_504)),
}


def space(genes: int, width: float) -> RealSpace:
    """Return a genome space of `genes` genes, each `width` wide and centred on 0."""
    side = np.full(genes, width / 2)
    return RealSpace(-side, side, tuple(f"gene {gene}" for gene in range(genes)))


def sphere(genomes: NDArray[np.float64]) -> Results:
    """Return scores (100 if all genes are 0.4 · 5.12) and two measures.

    The measures are the sums of the first and of the second half of the clipped genes.
    """
    best = 0.4 * BOUND
    worst = GENES * (BOUND + best) ** 2
    scores = 100 * (1 - np.square(genomes - best).sum(1) / worst)
    inside = np.abs(genomes) <= BOUND
    clipped = np.where(inside, genomes, BOUND / np.where(inside, 1, genomes))
    left, right = clipped[:, : GENES // 2].sum(1), clipped[:, GENES // 2 :].sum(1)
    return Results(genomes, scores, {"left": left, "right": right})


def evolve(search: MapElites, generations: int, seed: int) -> State:
    """Return the state of the search after `generations` generations."""
    genes, start = space(GENES, WIDTH), np.zeros(GENES)

    def context(generation: int, call: int) -> Context:
        rng = np.random.default_rng([seed, generation, call])
        return Context(genes, POPULATION, generation, rng, start)

    state = search.initial(context(0, 0))
    for generation in range(1, generations + 1):
        genomes, state = search.ask(state, None, context(generation, 1))
        state = search.tell(state, sphere(genomes), context(generation, 2))
    return state


def rank_one_as_pyribs() -> AbstractContextManager[object]:
    """Patch the emitters to weight the rank-one update as pyribs 0.12 does."""
    update = emitters.rank_one_update
    return mock.patch.object(
        emitters, "rank_one_update", lambda path, rate: update(path, rate * rate)
    )


def print_coverage(only: str | None, seeds: int, generations: int) -> None:
    """Print coverage and QD score of each variation next to the published figures."""
    print(
        f"{'':<19} {'coverage %':>13} {'published':>14} {'QD score':>9} {'published':>17}  minutes"
    )
    for name in [*VARIATIONS, *(f"{variation}{AS_PYRIBS}" for variation in ("cma-me", "cma-mae"))]:
        variation = name.removesuffix(AS_PYRIBS)
        if only not in (None, variation):
            continue
        search = MapElites(
            axes={"left": (-REACH, REACH), "right": (-REACH, REACH)},
            cells=(100, 100),
            variation=variation,
            **VARIATIONS[variation],
        )
        start = time.perf_counter()
        with rank_one_as_pyribs() if name != variation else nullcontext():
            found = [search.figures(evolve(search, generations, seed)) for seed in range(seeds)]
        minutes = (time.perf_counter() - start) / seeds / 60
        coverages = [100 * figures["coverage"] for figures in found]
        spread = f" ± {statistics.stdev(coverages):.2f}" if seeds > 1 else ""
        qd_score = statistics.mean(figures["QD score"] for figures in found)
        (mean, deviation), (qd_mean, qd_deviation) = PUBLISHED[variation]
        print(
            f"{name:<19} {f'{statistics.mean(coverages):.2f}{spread}':>13} "
            f"{f'{mean:.2f} ± {deviation:.2f}':>14} {qd_score:>9,.0f} "
            f"{f'{qd_mean:,} ± {qd_deviation:,}':>17}  {minutes:.1f}",
            flush=True,
        )


def elites(number: int) -> Results:
    """Return `number` genomes, each in a different cell of a grid of 200 × 200."""
    rng = np.random.default_rng(0)
    cells = np.stack(np.unravel_index(rng.permutation(40_000)[:number], (200, 200)))
    values = dict(zip("xy", (cells + 0.5) / 200, strict=True))
    return Results(rng.random((number, 48)) - 0.5, rng.random(number), values)


def improvements(held: Results) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield scores and measures of 100 genomes, all of which improve their cell, endlessly."""
    rng, values = np.random.default_rng(1), np.stack([*held.values.values()], 1)
    for generation in count(1):
        yield generation + rng.random(100), values[rng.integers(0, len(values), 100)]


def gaitsim_step(variation: str, held: Results) -> Callable[[], object]:
    """Return a function that asks and tells 100 genomes of 48 genes, given an archive's elites."""
    search = MapElites(axes={"x": (0, 1), "y": (0, 1)}, cells=(200, 200), variation=variation)
    rng, box = np.random.default_rng(0), space(48, 1.0)
    states = [search.initial(Context(box, 100, 0, rng))]
    states[0] = search.tell(states[0], held, Context(box, len(held.scores), 1, rng))
    news = improvements(held)

    def step() -> None:
        context = Context(box, 100, 2, rng)
        genomes, state = search.ask(states[0], None, context)
        scores, values = next(news)
        told = dict(zip("xy", values.T, strict=True))
        states[0] = search.tell(state, Results(genomes, scores, told), context)

    return step


def pyribs_step(variation: str, held: Results) -> Callable[[], object]:
    """Return the same function for pyribs.

    Its emitters have no bounds here, as pyribs would redraw each genome outside them.
    """
    from ribs.archives import GridArchive
    from ribs.emitters import EvolutionStrategyEmitter, GaussianEmitter, IsoLineEmitter
    from ribs.schedulers import Scheduler

    soft = {"learning_rate": 0.01, "threshold_min": 0.0} if variation == "cma-mae" else {}
    archive = GridArchive(solution_dim=48, dims=(200, 200), ranges=[(0, 1), (0, 1)], **soft)
    archive.add(held.genomes, held.scores, np.stack([*held.values.values()], 1))
    shared = {"x0": np.zeros(48), "seed": 1}
    if variation == "isotropic":
        sources = [GaussianEmitter(archive, sigma=0.01, batch_size=100, **shared)]
    elif variation == "line":
        sigmas = {"iso_sigma": 0.01, "line_sigma": 0.2}
        sources = [IsoLineEmitter(archive, batch_size=100, **sigmas, **shared)]
    else:
        annealing = {"ranker": "imp", "selection_rule": "mu", "restart_rule": "basic"}
        rules = annealing if soft else {"ranker": "2imp"}
        sources = [
            EvolutionStrategyEmitter(archive, sigma0=0.2, batch_size=20, **rules, **shared)
            for _ in range(5)
        ]
    scheduler = Scheduler(archive, sources)
    news = improvements(held)

    def step() -> None:
        scheduler.ask()
        scheduler.tell(*next(news))

    return step


def processor_times(*steps: Callable[[], object]) -> list[float]:
    """Return the processor time of a call of each step, seconds.

    The steps take turns in five rounds. Each round gives a mean of 20 calls; the smallest mean is
    returned.
    """
    means: list[list[float]] = [[] for _ in steps]
    for _ in range(5):
        for step, found in zip(steps, means, strict=True):
            step()
            start = time.process_time()
            for _ in range(20):
                step()
            found.append((time.process_time() - start) / 20)
    return [min(found) for found in means]


def print_times() -> None:
    """Print the processor times of ask and tell, and those of pyribs if it is installed."""
    print("\nask and tell for 100 genomes of 48 genes, all of which improve a cell: processor time")
    for variation in VARIATIONS:
        for number in (1_000, 15_000, 40_000):
            held = elites(number)
            steps = [gaitsim_step(variation, held)]
            if importlib.util.find_spec("ribs"):
                steps.append(pyribs_step(variation, held))
            ours, *theirs = processor_times(*steps)
            beside = [f"pyribs {milliseconds(t)}, {times(t / ours)}" for t in theirs]
            print_figure(f"{variation}, {number:,} elites", milliseconds(ours), *beside)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=10_000)
    parser.add_argument("--only", choices=list(VARIATIONS))
    arguments = parser.parse_args()
    print_machine()
    print_coverage(arguments.only, arguments.seeds, arguments.iterations)
    print_times()


if __name__ == "__main__":
    main()
