"""Age-fitness Pareto optimisation: new genomes compete only with others of their age."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    Context,
    Genomes,
    GenomeSpace,
    Results,
    Search,
    State,
    option,
    parents_of_children,
)
from gaitsim_searches.breeding import START_SHARE
from gaitsim_searches.domination import front_ranks


class AgeFitness(Search):
    """Protects new bodies and gaits: an individual survives until a younger one scores higher.

    Schmidt and Lipson 2011, "Age-fitness Pareto optimization". The age of an individual is the
    number of generations since the oldest of its genes were drawn at random. Parents are drawn
    uniformly from the survivors; each generation also has random newcomers. Of survivors and
    children, those that are on the first fronts of high score and low age survive, and on the last
    such front those with the highest scores.

    State: `genomes` (survivors, genes) with their `scores` and `ages`; `young` (population,), the
    ages of the genomes that were asked for.
    """

    newcomers: int = option(
        1, "number of random individuals in each generation after the first", ge=1
    )
    start_share: float = START_SHARE

    portable: ClassVar[bool] = True
    operators: ClassVar[tuple[str, ...]] = ("crossover", "mutation")
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the population has no room for the newcomers, or ''."""
        if self.newcomers < population:
            return ""
        return f"{self.newcomers:,} newcomers leave no room in a population of {population:,}"

    def initial(self, context: Context) -> State:
        """Return a state without survivors."""
        return {
            "genomes": np.empty((0, context.space.genes), context.space.dtype),
            "scores": np.empty(0),
            "ages": np.empty(0, np.int64),
            "young": np.empty(0, np.int64),
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return children of the survivors, and newcomers."""
        operators, rng = context.operators, context.rng
        if operators is None:
            raise ValueError("the search needs operators")
        genomes, wanted = state["genomes"], context.population - self.newcomers
        if not len(genomes):
            young = np.zeros(context.population, np.int64)
            return context.begin(self.start_share, operators.mutate), {**state, "young": young}
        parents = rng.integers(0, len(genomes), (wanted, 2))
        children = operators.cross(genomes, parents, wanted)
        ages = np.resize(state["ages"][parents].max(axis=1), wanted)
        new, unrelated = context.random(self.newcomers), np.full((self.newcomers, 2), -1)
        asked = np.concatenate([operators.mutate(children), new])
        context.record_parents(
            np.concatenate([parents_of_children(parents, wanted), unrelated]),
            np.concatenate([children, new]),
        )
        return asked, {**state, "young": np.append(ages, np.zeros(self.newcomers, np.int64))}

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Select the survivors from the previous survivors and the evaluated genomes."""
        genomes = np.concatenate([state["genomes"], results.genomes])
        scores = np.concatenate([state["scores"], results.scores])
        ages = np.concatenate([state["ages"], state["young"]]) + 1
        costs = np.stack([-scores, ages.astype(np.float64)], axis=1)
        ranks = front_ranks(costs)
        kept = np.lexsort((-scores, ranks))[: context.population]
        return {**state, "genomes": genomes[kept], "scores": scores[kept], "ages": ages[kept]}

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the age of the best survivor, and the mean age."""
        ages, scores = state["ages"], state["scores"]
        if not len(ages):
            return {"age of best": 0.0, "mean age": 0.0}
        return {"age of best": float(ages[scores.argmax()]), "mean age": float(ages.mean())}

    def remembered(self, state: State) -> Genomes | None:
        """Return the survivors."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores of the survivors."""
        return {**state, "scores": results.scores}

    def mismatch(self, state: State, context: Context) -> str:
        """Return why the survivors do not fit the body, or ''."""
        count = len(state["genomes"])
        arrays: dict[str, NDArray[Any]] = {name: state[name] for name in ("scores", "ages")}
        if any(array.shape != (count,) for array in arrays.values()):
            return "its survivors have inconsistent arrays"
        if count and not context.space.contains(state["genomes"]):
            return "its survivors are of a body with different genes or bounds"
        return ""
