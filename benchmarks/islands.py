"""Scores of islands and of one population after the same number of evaluations, over repeats.

    python benchmarks/islands.py [PRESET] [REPEATS] [SEED]

The four searches begin with random genomes. They differ only in how the individuals are divided
into populations, and for the fly in the number of elites. p is the p-value of a Mann-Whitney test
against one population.
"""

import sys

import numpy as np
from scipy.stats import mannwhitneyu

from gaitsim.evaluation import Evaluator
from gaitsim.evolution.repeats import evolve_repeats
from gaitsim.experiment import load_experiment

ISLANDS = 4
# Individuals, generations, elites of one population, elites of each island.
BUDGETS = {"spider-genetic": (200, 150, 2, 2), "fly-genetic": (100, 60, 4, 1)}
SEARCHES = {
    "one population": {},
    "isolated": {"islands.number": ISLANDS, "islands.migrants": 0},
    "ring": {"islands.number": ISLANDS},
    "all with all": {"islands.number": ISLANDS, "islands.topology": "all"},
}


def final_scores(preset: str, search: str, repeats: int, seed: int) -> np.ndarray:
    """Return the best score of each repeat in the last generation, (repeats,)."""
    individuals, generations, *elites = BUDGETS[preset]
    populations = ISLANDS if SEARCHES[search] else 1
    experiment = load_experiment(
        preset,
        {
            "seed": seed,
            "evolution.generations": generations,
            "evolution.population": individuals // populations,
            "search.start": "random",
            "search.elites": elites[populations > 1],
            **SEARCHES[search],
        },
    )
    with Evaluator(experiment) as evaluator:
        *_, last = evolve_repeats(experiment, evaluator.evaluate, repeats)
    return last


def main() -> None:
    """Print a line for each search."""
    presets = sys.argv[1:2] or [*BUDGETS]
    repeats, seed = (int(text) for text in [*sys.argv[2:4], "12", "0"][:2])
    for preset in presets:
        individuals, generations, *_ = BUDGETS[preset]
        print(
            f"{preset}: {individuals * generations:,} evaluations, {repeats} repeats, seed {seed}"
        )
        print(f"{'':<16}{'median':>8}{'quartiles':>18}{'worst':>8}{'best':>8}{'p':>8}")
        first: np.ndarray | None = None
        for search in SEARCHES:
            best = final_scores(preset, search, repeats, seed)
            first = best if first is None else first
            low, middle, high = np.quantile(best, [0.25, 0.5, 0.75])
            p = f"{mannwhitneyu(first, best).pvalue:8.3f}" if best is not first else ""
            print(
                f"{search:<16}{middle:>8.2f}{low:>9.2f}{high:>9.2f}"
                f"{best.min():>8.2f}{best.max():>8.2f}{p}",
                flush=True,
            )


if __name__ == "__main__":
    main()
