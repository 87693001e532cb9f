"""Random search: new random genomes in each generation, the baseline for all searches."""

from typing import ClassVar, Literal

from gaitsim.plugin import Context, Genomes, GenomeSpace, Results, Search, State, option


class RandomSearch(Search):
    """Draws every genome from the body's initial distribution, and learns nothing.

    Brooks 1958, "A discussion of random methods for seeking maxima".
    """

    start: Literal["random"] = option(
        "random", "where the search begins: random genomes, because it never uses the body's starts"
    )

    portable: ClassVar[bool] = True
    several: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return random genomes; with a warm start, the very first are its genomes."""
        kept = max(1, min(len(context.starts), context.population))
        return context.begin(kept / context.population, lambda genomes: genomes), state
