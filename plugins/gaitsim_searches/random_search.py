"""Random search: fresh genomes in each generation, the least that a search has to beat."""

from math import prod
from typing import ClassVar

from gaitsim.contracts import Genomes
from gaitsim.contracts.search import Context, Results, Search, State


class RandomSearch(Search):
    """Draws all genomes as the body draws its first ones, and learns nothing.

    Brooks 1958, "A discussion of random methods for seeking maxima".
    """

    several: ClassVar[bool] = True

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return fresh genomes; a warm start is the first one of the first generation."""
        shape = (*context.populations, context.population)
        genomes = context.random(prod(shape)).reshape(*shape, context.space.genes)
        if last is None and context.start is not None:
            genomes[..., 0, :] = context.start
        return genomes, state
