"""Success of searches from start points and from random genomes, over seeds.

    python benchmarks/starts.py [BODY …] [--seeds N] [--first SEED] [--only WORD]

Each line gives the median, lowest and highest best score after a number of evaluations, the share
of seeds that have reached each target by then, and, in the last line of a search, the number of
evaluations that half of the seeds, and nine in ten, needed to reach the highest target.
"""

import argparse
import math
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

import gaitsim as gs

START, RANDOM = {"search.start": "body"}, {"search.start": "random"}


FOUR: dict[str, Any] = {"organism.legs": 4}


@dataclass(frozen=True)
class Body:
    """A comparison of searches on one body.

    Attributes:
        searches: preset and options of each search, by name.
        evaluations: numbers of evaluations after which scores are compared.
        targets: scores to reach.
        seeds: number of seeds.
    """

    searches: dict[str, tuple[str, dict[str, Any]]]
    evaluations: tuple[int, ...]
    targets: tuple[float, ...]
    seeds: int


def pair(name: str, preset: str) -> dict[str, tuple[str, dict[str, Any]]]:
    """Return a preset from its start points, and from random genomes."""
    return {f"{name}, start": (preset, START), f"{name}, random": (preset, RANDOM)}


BODIES = {
    "spider": Body(
        pair("cma-es", "spider") | pair("genetic", "spider-genetic"),
        (5_000, 10_000, 20_000),
        (2.3, 2.55, 2.6),
        50,
    ),
    "fly": Body(
        pair("cma-es", "fly") | pair("genetic", "fly-genetic"), (2_500, 5_000, 10_000), (5, 10), 30
    ),
    "walker": Body(
        {"genetic, random": ("walker", {}), "cma-es, random": ("walker-cma", {})},
        (1_000, 2_000),
        (3, 3.5),
        20,
    ),
    "walker-four": Body(
        {
            "cma-es, start": ("walker-cma", FOUR),
            "cma-es, random": ("walker-cma", FOUR | RANDOM),
            "genetic, start": ("walker", FOUR | {"evolution.population": 40}),
        },
        (600, 1_200),
        (3, 5),
        20,
    ),
    "quadruped": Body(pair("cma-es", "quadruped"), (240, 480), (2, 3), 20),
    "hexapod": Body(pair("cma-es", "hexapod"), (240, 480), (2, 3), 20),
}


def best_scores(preset: str, options: dict[str, Any], seed: int, most: int) -> np.ndarray:
    """Return evaluations and the best score so far after each generation, (2, generations)."""
    given = {**options, "evolution.max_evaluations": most}
    search = gs.evolve(preset, seed=seed, generations=most, set=given, workers=1)
    found = [(one.progress.evaluations, one.progress.best_score) for one in search]
    return np.array(found).T


def after(evaluations: int, run: np.ndarray) -> float:
    """Return the best score within a number of evaluations."""
    return float(run[1, run[0] <= evaluations].max(initial=-math.inf))


def needed(target: float, run: np.ndarray) -> float:
    """Return the number of evaluations until a target is reached, or ∞."""
    return float(run[0, run[1] >= target].min(initial=math.inf))


def main() -> None:
    """Print the lines of each search on each body."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bodies", nargs="*", default=[*BODIES])
    parser.add_argument("--seeds", type=int)
    parser.add_argument("--first", type=int, default=5000)
    parser.add_argument("--only", default="")
    given = parser.parse_args()
    print(f"load average {os.getloadavg()[0]:.1f}", flush=True)
    for name in given.bodies:
        body = BODIES[name]
        seeds = range(given.first, given.first + (given.seeds or body.seeds))
        print(f"\n{name}: {len(seeds)} seeds from {seeds[0]}", flush=True)
        for search, (preset, options) in body.searches.items():
            if given.only not in search:
                continue
            runs = [best_scores(preset, options, seed, body.evaluations[-1]) for seed in seeds]
            for count in body.evaluations:
                scores = np.array([after(count, run) for run in runs])
                shares = (f"≥ {aim:g}: {np.mean(scores >= aim):.0%}" for aim in body.targets)
                print(
                    f"{search:<18}{count:>7,}  median {np.median(scores):.3f} "
                    f"({scores.min():.3f} to {scores.max():.3f})  {', '.join(shares)}",
                    flush=True,
                )
            times = np.array([needed(body.targets[-1], run) for run in runs])
            half, most = np.quantile(times, [0.5, 0.9], method="inverted_cdf")
            print(
                f"{'':<18}evaluations to {body.targets[-1]:g}: half of the seeds {half:,.0f}, ",
                end="",
            )
            print(f"nine in ten {most:,.0f}", flush=True)


if __name__ == "__main__":
    main()
