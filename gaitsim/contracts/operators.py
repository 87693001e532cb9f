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
            scores: (population,), higher is better; may hold −inf, never NaN.
            pairs: number of pairs to choose.
            rng: the only source of randomness.

        Returns:
            Indices of mother and father of each pair, (pairs, 2).
        """

    def parents_each(
        self, scores: NDArray[np.float64], pairs: int, rng: np.random.Generator
    ) -> NDArray[np.intp]:
        """Choose parents in each of several populations, scores (populations, population).

        The default calls `parents` for one population after another. Override it if all of them
        can be handled at once, which speeds up studies.

        Returns:
            Indices into each population, (populations, pairs, 2). For a single population, they
            equal those of `parents`.
        """
        return np.stack([self.parents(row, pairs, rng) for row in scores])

    def objection(self, population: int, elites: int, children: int) -> str:
        """Return why this selection cannot breed populations of this size, or ''.

        Args:
            population: individuals in each generation.
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
            The breeding step replaces the children of the other pairs with copies of the parents.
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
        """Cross every pair: mothers (pairs, genes) with fathers (pairs, genes).

        Returns:
            A new array (pairs × children, genes) in the dtype of the space: all first children,
            then all second ones. Genes may exceed their bounds; the breeding step repairs them
            after mutation.
        """


class Mutation(Plugin):
    """An operator that changes genomes at random.

    Attributes:
        spaces: genome spaces that the mutation supports.
    """

    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace, BitSpace)

    @abstractmethod
    def mutate(self, genomes: Genomes, space: GenomeSpace, rng: np.random.Generator) -> Genomes:
        """Mutate every genome, (population, genes) -> a new array of the same shape and dtype.

        Genes may exceed their bounds; the breeding step repairs them.
        """
