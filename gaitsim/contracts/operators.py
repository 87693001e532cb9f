"""The contracts of selection, crossover and mutation."""

from abc import abstractmethod
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.plugin import Plugin, option
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace


class Selection(Plugin):
    """Chooses who breeds."""

    @abstractmethod
    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents.

        Args:
            scores: (population,), more is better; may hold −inf, never NaN.
            pairs: how many pairs are wanted.
            rng: the only source of randomness.

        Returns:
            Indices of mother and father of each pair, (pairs, 2).
        """

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents in each of several populations, (populations, population).

        Returns:
            Indices into each population, (populations, pairs, 2). For one population it
            is what `parents` chooses. A selection that many repeats use can do better
            than this, which takes one population after the other.
        """
        return np.stack([self.parents(row, pairs, rng) for row in scores])

    def objection(self, population: int, elites: int, children: int) -> str:
        """Why populations of this size cannot be bred as this selection means it, or ''.

        Args:
            population: individuals in each generation.
            elites: how many of them are carried over.
            children: how many each pair of parents has.
        """
        return ""


class Crossover(Plugin):
    """Makes children of pairs of parents.

    Attributes:
        children: how many children a pair has; an option of every crossover, which
            one that can make only one number of them narrows to `Literal[1]` or
            `Literal[2]`.
        spaces: the genome spaces it works on.
    """

    children: Literal[1, 2] = option(2, "how many children each pair of parents has")
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Cross (pairs, genes) with (pairs, genes), new arrays.

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
