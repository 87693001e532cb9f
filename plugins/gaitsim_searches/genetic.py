"""The genetic algorithm: selection, crossover and mutation in each generation."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import (
    Context,
    Genomes,
    GenomeSpace,
    Operators,
    Results,
    Search,
    State,
    option,
)


class Genetic(Search):
    """A generational genetic algorithm with elitism (Holland 1975, De Jong 1975).

    The best individuals are copied. The experiment's operators select and cross parents, and mutate
    their children. With a warm start, the first population is its genome and mutants of it.
    """

    elites: int = option(
        1, "number of best individuals copied unchanged into the next generation", ge=0
    )

    portable: ClassVar[bool] = True
    operators: ClassVar[tuple[str, ...]] = ("selection", "crossover", "mutation")
    several: ClassVar[bool] = True

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
            return _first_population(context, operators), state
        if self.elites == 1:  # fifty times as fast as sorting
            best = last.scores.argmax(axis=-1)[..., None]
        else:  # a stable sort keeps the order of equal scores
            best = np.argsort(-last.scores, axis=-1, kind="stable")[..., : self.elites]
        wanted = context.population - self.elites
        parents = operators.parents(last.scores, wanted)
        children = operators.mutate(operators.cross(last.genomes, parents, wanted))
        kept = np.take_along_axis(last.genomes, best[..., None], axis=-2)
        return np.concatenate([kept, children], axis=-2), state


def _first_population(context: Context, operators: Operators) -> Genomes:
    """Return the first population, (*populations, population, genes)."""
    if context.start is not None:
        copies = np.tile(context.start, (context.population - 1, 1))
        return np.concatenate([context.start[None], operators.mutate(copies)])
    shape = (*context.populations, context.population)
    return context.random(int(np.prod(shape))).reshape(*shape, -1)
