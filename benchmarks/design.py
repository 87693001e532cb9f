"""A planted answer: robots with spoilt proportions, whose dimensions evolve back.

The shanks of a body are 30 % shorter, and its thighs 30 % longer. With equal evaluations, the gait
of the original is evolved, that of the spoilt body, gait and dimensions of the spoilt body jointly,
and nested: the gait of one body after another, each with dimensions drawn near the best so far. It
prints one row for each run, and for each kind of search the share of seeds that reach 95 % of the
median of the original.
"""

import argparse
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import Experiment, load_experiment

DIMENSIONS = {"quadruped": ("thigh", "shank"), "hexapod": ("femur", "tibia")}
SPOILT, RANGES = (1.3, 0.7), ([0.6, 1.2], [0.8, 1.6])
STEPS, STEP = 8, 0.15  # bodies of the nested search, and standard deviation of their factors
ENOUGH = 0.95


def best(experiment: Experiment, start: Any = None) -> tuple[float, Any]:
    """Return the best score of a run, and its genome."""
    score, genome = -np.inf, None
    for last in evolve(experiment, partial(evaluate, experiment), starts=start):
        if last.scores.max() > score:
            score, genome = float(last.scores.max()), last.genomes[last.best]
    return score, genome


def load(
    body: str, fixed: Mapping[str, Any], overrides: Mapping[str, Any], share: int = 1
) -> Experiment:
    """Return the preset of a body, with a share of its generations."""
    generations = load_experiment(body).evolution.generations // share
    return load_experiment(body, {"evolution.generations": generations, **fixed, **overrides})


def nested(
    load: Callable[[dict[str, Any]], Experiment],
    spoilt: Mapping[str, Any],
    names: tuple[str, ...],
    seed: int,
) -> tuple[float, list[float]]:
    """Return the best score of gaits of one body after another, and its factors."""
    rng = np.random.default_rng(seed)
    top, factors, start = -np.inf, np.ones(len(names)), None
    low, high = np.array(RANGES).T
    for step in range(STEPS):
        tried = factors if not step else np.clip(rng.normal(factors, STEP), low, high)
        dimensions = dict(zip(names, tried.tolist(), strict=True))
        score, genome = best(load({**spoilt, "organism.dimensions": dimensions}), start)
        if score > top:
            top, factors, start = score, tried, genome[None]
    return top, factors.tolist()


def main() -> None:
    """Print a row for each run, and the shares of success."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", nargs="*", default=[*DIMENSIONS])
    parser.add_argument("--kinds", nargs="*", default=["original", "spoilt", "joint", "nested"])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--duration", type=float, default=10.0, help="of a rollout, s")
    given = parser.parse_args()
    scores: dict[tuple[str, str], list[float]] = defaultdict(list)
    for seed in range(given.first, given.first + given.seeds):
        for body in given.bodies:
            names = DIMENSIONS[body]
            factors = dict(zip(names, SPOILT, strict=True))
            changed = load_experiment(body, {"organism.dimensions": factors}).organism
            spoilt = {"organism.model": str(changed.text)}  # type: ignore[attr-defined]
            evolving = {
                "organism.evolve": [*names],
                "organism.ranges": dict(zip(names, RANGES, strict=True)),
            }
            loaded = partial(load, body, {"seed": seed, "organism.duration": given.duration})
            for kind in given.kinds:
                own: list[float] = []
                if kind == "nested":
                    score, own = nested(partial(loaded, share=STEPS), spoilt, names, seed)
                else:
                    options = {} if kind == "original" else spoilt
                    options = options | (evolving if kind == "joint" else {})
                    score, genome = best(loaded(options))
                    own = genome[-len(names) :].tolist() if kind == "joint" else []
                scores[body, kind].append(score)
                lengths = " ".join(
                    f"{name} {factor * spoiling:.2f}"
                    for name, factor, spoiling in zip(names, own, SPOILT, strict=False)
                )
                print(f"{body:10} seed {seed}  {kind:9} {score:6.3f}  {lengths}", flush=True)
    for (body, kind), values in scores.items():
        goal = ENOUGH * float(np.median(scores[body, "original"]))
        share = np.mean(np.array(values) >= goal)
        print(
            f"{body:10} {kind:9} median {np.median(values):6.3f}, "
            f"{share:.0%} of {len(values)} seeds reach {ENOUGH:.0%} of the original's median"
        )


if __name__ == "__main__":
    main()
