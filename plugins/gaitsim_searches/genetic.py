"""The genetic algorithm: selection, crossover and mutation in each generation."""

from typing import ClassVar

import numpy as np

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


class Genetic(Search):
    """A generational genetic algorithm with elitism (Holland 1975, De Jong 1975).

    The best individuals are copied. The experiment's operators select and cross parents, and mutate
    their children. Part of the first population consists of start points and mutants of them.
    """

    elites: int = option(
        1, "number of best individuals copied unchanged into the next generation", ge=0
    )

    start_share: float = START_SHARE

    portable: ClassVar[bool] = True
    operators: ClassVar[tuple[str, ...]] = ("selection", "crossover", "mutation")
    several: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the population has no room for the elites, or ''."""
        if self.elites < population:
            return ""
        return f"{self.elites:,} elites leave no room in a population of {population:,}"

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Breed the next population: the elites, best first, then the children.

        Children beyond the population's size are dropped.
        """
        operators = context.operators
        if operators is None:
            raise ValueError("a genetic algorithm needs operators")
        if last is None:
            return context.begin(self.start_share, operators.mutate), state
        if self.elites == 1:  # fifty times as fast as sorting
            best = last.scores.argmax(axis=-1)[..., None]
        else:  # a stable sort keeps the order of equal scores
            best = np.argsort(-last.scores, axis=-1, kind="stable")[..., : self.elites]
        wanted = context.population - self.elites
        parents = operators.parents(last.scores, wanted)
        crossed = operators.cross(last.genomes, parents, wanted)
        children = operators.mutate(crossed)
        kept = np.take_along_axis(last.genomes, best[..., None], axis=-2)
        copied = np.stack([best, np.full_like(best, -1)], axis=-1)
        context.record_parents(
            np.concatenate([copied, parents_of_children(parents, wanted)], axis=-2),
            np.concatenate([kept, crossed], axis=-2),
        )
        return np.concatenate([kept, children], axis=-2), state
