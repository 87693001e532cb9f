"""The contracts of selection, crossover and mutation."""

from abc import abstractmethod
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.plugin import Plugin, option
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace


class Selection(Plugin):
    """Chooses the parents."""

    @abstractmethod
    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents.

        Args:
            scores: (population,), more is better; may hold −inf, never NaN.
            pairs: number of pairs to choose.
            rng: the only source of randomness.

        Returns:
            Indices of mother and father of each pair, (pairs, 2).
        """

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents in each of several populations, (populations, population).

        Returns:
            Indices into each population, (populations, pairs, 2); of one population, the same
            as `parents`. This default takes one population after the other; a selection that
            studies use can override it with something faster.
        """
        return np.stack([self.parents(row, pairs, rng) for row in scores])

    def objection(self, population: int, elites: int, children: int) -> str:
        """Return why this selection cannot breed populations of this size, or ''.

        Args:
            population: individuals in each generation.
            elites: number of individuals copied to the next generation.
            children: number of children of each pair.
        """
        return ""


class Crossover(Plugin):
    """Makes children of pairs of parents.

    Attributes:
        children: number of children of a pair, an option of every crossover. A crossover that
            supports only one number narrows it to `Literal[1]` or `Literal[2]`.
        pair_probability: the crossover probability p_c, an option of every crossover; the
            breeding step replaces the children of the other pairs by copies (Holland 1975).
        spaces: the genome spaces it works on.
    """

    children: Literal[1, 2] = option(2, "how many children each pair of parents has")
    pair_probability: float = option(
        1.0,
        "probability that a pair is crossed at all; otherwise its children are copies, the first "
        "of the mother, the second of the father",
        ge=0,
        le=1,
    )
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Cross every pair, (pairs, genes) with (pairs, genes), new arrays.

        Returns:
            (pairs × children, genes) in the dtype of the space: all first children,
            then all second ones. Genes may leave the bounds; the breeding step
            repairs them after mutation.
        """


class Mutation(Plugin):
    """Changes genomes at random.

    Attributes:
        spaces: the genome spaces it works on.
    """

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Mutate every genome, (population, genes) -> new array of that shape and dtype.

        Genes may leave the bounds; the breeding step repairs them.
        """
