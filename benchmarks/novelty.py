"""Flies from random networks, evolved for their score, for novelty, or for both.

Each search gets the evaluations of the preset `fly-genetic`. It prints the best score of each run,
and how many runs end above the ground and above 5 m.
"""

import argparse
import time
from collections import defaultdict
from functools import partial

import numpy as np

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment

AXES = {
    "final altitude": [-20.0, 20.0],
    "horizontal distance": [0.0, 10.0],
    "largest tilt": [0.0, 180.0],
}
NOVEL = {"search.plugin": "novelty", "search.axes": AXES, "search.start": "random"}
KINDS = {
    "score": {},
    "novelty": NOVEL,
    "both": {**NOVEL, "search.goal": "both"},
}


def main() -> None:
    """Print a row for each run, and a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kinds", nargs="*", default=[*KINDS], choices=KINDS)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=4000)
    parser.add_argument("--generations", type=int, default=200)
    given = parser.parse_args()
    found: dict[str, list[float]] = defaultdict(list)
    for seed in range(given.first, given.first + given.seeds):
        for kind in given.kinds:
            sizes = {"seed": seed, "evolution.generations": given.generations}
            experiment = load_experiment("fly-genetic", {**sizes, **KINDS[kind]})
            start = time.perf_counter()
            best = max(
                float(one.scores.max()) for one in evolve(experiment, partial(evaluate, experiment))
            )
            found[kind].append(best)
            seconds = time.perf_counter() - start
            print(f"seed {seed}  {kind:8} {best:7.2f} m  {seconds:4.0f} s", flush=True)
    for kind, scores in found.items():
        values = np.array(scores)
        low, middle, high = np.quantile(values, [0, 0.5, 1])
        print(
            f"{kind:8} median {middle:.2f} m ({low:.2f} to {high:.2f}), "
            f"{(values > 0).sum()} of {len(values)} above 0, {(values > 5).sum()} above 5 m"
        )


if __name__ == "__main__":
    main()
