"""Random search: new random genomes in each generation, the baseline for all searches."""

from math import prod
from typing import ClassVar

from gaitsim.contracts import Genomes
from gaitsim.contracts.search import Context, Results, Search, State


class RandomSearch(Search):
    """Draws every genome from the body's initial distribution, and learns nothing.

    Brooks 1958, "A discussion of random methods for seeking maxima".
    """

    portable: ClassVar[bool] = True
    several: ClassVar[bool] = True

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return random genomes; a warm start is the first genome of the first generation."""
        shape = (*context.populations, context.population)
        genomes = context.random(prod(shape)).reshape(*shape, context.space.genes)
        if last is None and context.start is not None:
            genomes[..., 0, :] = context.start
        return genomes, state
