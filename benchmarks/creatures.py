"""Creatures: bodies and gaits together, with and without protection of new bodies.

Each kind of search gets the same number of evaluations. It prints one row for each run: the best
score, the speed of the best body in body lengths per second, its modules, the time, and its plan.

`learning` is lifetime learning, as in ARIEL's examples: a child's gait is improved for some
generations by a (1 + 1) evolution strategy before it competes with other bodies.
"""

import argparse
import time
import tomllib
from collections import defaultdict
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from gaitsim.contracts import Context, Genomes, GenomeSpace, Results, Search, State, option
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim_creatures.operators import MutateTree

KINDS = ("genetic", "age-fitness", "learning")


class Learning(Search):
    """Genetic search among bodies whose gaits learn for a few generations.

    State: `genomes` and `scores` of bodies that have learned; `young`, the best gaits of those that
    learn, with their `found` scores; `step` of their learning.
    """

    steps: int = option(4, "generations of learning of each body", ge=1)

    operators: ClassVar[tuple[str, ...]] = ("selection", "crossover", "mutation")
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)

    def initial(self, context: Context) -> State:
        """Return an empty state."""
        none = np.empty((0, context.space.genes))
        step = np.array(0, np.int64)
        return {
            "genomes": none,
            "scores": np.empty(0),
            "young": none,
            "found": np.empty(0),
            "step": step,
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return new bodies, or gaits of those that learn."""
        operators = context.operators
        assert operators is not None
        if state["step"]:
            gaits = MutateTree(body=0.0, gait=1.0, symmetry=0.0)
            return context.repair(gaits.mutate(state["young"], context.space, context.rng)), state
        if not len(state["genomes"]):
            return context.begin(0.1, operators.mutate), state
        parents = operators.parents(state["scores"], context.population)
        return operators.mutate(
            operators.cross(state["genomes"], parents, context.population)
        ), state

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Keep the better gaits; after the last step, bodies compete with their parents."""
        young, found, step = results.genomes, results.scores, int(state["step"])
        if step:
            better = results.scores > state["found"]
            young = np.where(better[:, None], results.genomes, state["young"])
            found = np.where(better, results.scores, state["found"])
        if step + 1 < self.steps:
            return {**state, "young": young, "found": found, "step": np.array(step + 1, np.int64)}
        genomes = np.concatenate([state["genomes"], young])
        scores = np.concatenate([state["scores"], found])
        best = np.argsort(-scores, kind="stable")[: context.population]
        return {
            **state,
            "genomes": genomes[best],
            "scores": scores[best],
            "step": np.array(0, np.int64),
        }


def main() -> None:
    """Print a row for each run, and medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kinds", nargs="*", default=KINDS, choices=KINDS)
    parser.add_argument("--symmetries", nargs="*", default=["gene"])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--set", nargs=2, action="append", default=[], metavar=("KEY", "VALUE"))
    given = parser.parse_args()
    more = {key: tomllib.loads(f"value = {value}")["value"] for key, value in given.set}
    overrides: dict[str, Any]
    scores: dict[tuple[str, str], list[float]] = defaultdict(list)
    for seed in range(given.first, given.first + given.seeds):
        for symmetry in given.symmetries:
            for kind in given.kinds:
                overrides = {"seed": seed, "organism.symmetry": symmetry}
                if kind != "age-fitness":
                    overrides |= {"search.plugin": "genetic", "search.elites": 2}
                    overrides["selection.plugin"] = "tournament"
                experiment = load_experiment("creature", {**overrides, **more})
                if kind == "learning":
                    experiment = replace(experiment, search=Learning())
                start = time.perf_counter()
                best, genome = -np.inf, None
                for last in evolve(experiment, partial(evaluate, experiment)):
                    if last.scores.max() > best:
                        best, genome = float(last.scores.max()), last.genomes[last.best]
                organism = experiment.organism
                measured = organism.measures(organism.move(genome[None]))
                own, modules = measured["relative speed"].values[0], measured["modules"].values[0]
                scores[kind, symmetry].append(best)
                print(
                    f"seed {seed}  {kind:11} {symmetry:6} score {best:6.3f}  {own:5.3f} 1/s  "
                    f"{modules:2.0f} modules  {time.perf_counter() - start:4.0f} s  "
                    f"{organism.embody(genome)[0].body}",
                    flush=True,
                )
    for (kind, symmetry), found in scores.items():
        print(
            f"{kind:11} {symmetry:6} median {np.median(found):.3f} of {len(found)} seeds: {found}"
        )


if __name__ == "__main__":
    main()
