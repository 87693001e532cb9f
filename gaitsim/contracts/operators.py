"""The contracts of selection, crossover and mutation."""

from abc import abstractmethod
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.plugin import Plugin, option
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace


class Selection(Plugin):
    """An operator that chooses parents."""

    @abstractmethod
    def parents(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents.

        Args:
            scores: score of each individual, (population,); higher is better. May contain −inf, but
                never NaN.
            pairs: number of pairs to choose.
            rng: only source of randomness.

        Returns:
            Indices of the mother and the father of each pair, (pairs, 2).
        """

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents in each of several populations.

        The default calls `parents` for one population after another. Override it to handle all
        populations at once, which is faster.

        Args:
            scores: score of each individual, (populations, population).
            pairs: number of pairs to choose in each population.
            rng: only source of randomness.

        Returns:
            Indices into each population, (populations, pairs, 2). For a single population, they
            must equal the result of `parents`.
        """
        return np.stack([self.parents(row, pairs, rng) for row in scores])

    def objection(self, population: int, elites: int, children: int) -> str:
        """Return why this selection does not support populations of this size, or ''.

        Args:
            population: number of individuals in each generation.
            elites: number of individuals copied unchanged into the next generation.
            children: number of children per pair.
        """
        return ""


class Crossover(Plugin):
    """An operator that combines pairs of parents into children.

    Attributes:
        children: number of children per pair, an option of every crossover. A crossover that
            supports only one number narrows it to `Literal[1]` or `Literal[2]`.
        pair_probability: crossover probability p_c (Holland 1975), an option of every crossover.
            The breeding step replaces the children of pairs that are not crossed with copies of
            their parents.
        spaces: genome spaces that the crossover supports.
    """

    children: Literal[1, 2] = option(2, "number of children of each pair of parents")
    pair_probability: float = option(
        1.0,
        "probability that a pair is crossed; otherwise its first child is a copy of the mother, "
        "and its second child a copy of the father",
        ge=0,
        le=1,
    )
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Cross each mother with the father in the same row.

        Args:
            mothers: genomes, (pairs, genes).
            fathers: genomes, (pairs, genes).
            space: genome space of the parents.
            rng: only source of randomness.

        Returns:
            A new array of shape (pairs × children, genes) in the dtype of the space: the first
            child of every pair, then the second child of every pair. Genes may exceed their
            bounds; the breeding step repairs them after mutation.
        """


class Mutation(Plugin):
    """An operator that changes genomes at random.

    Attributes:
        spaces: genome spaces that the mutation supports.
    """

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Return mutated copies of all genomes.

        Args:
            genomes: genomes to mutate, (population, genes).
            space: genome space of the genomes.
            rng: only source of randomness.

        Returns:
            A new array of the same shape and dtype. Genes may exceed their bounds; the breeding
            step repairs them.
        """
