"""Crossover operators, which combine pairs of parents into children."""

from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Crossover, Genomes, GenomeSpace, RealSpace, option
from gaitsim.plugin.toolkit import power, uniform
from gaitsim_operators.shared import distinct_pairs, real_space


def parent_differences(mothers: Genomes, fathers: Genomes, space: RealSpace) -> NDArray[np.float64]:
    """Return father minus mother, (pairs, genes); periodic genes take the shorter way round."""
    direct: NDArray[np.float64] = fathers - mothers
    if space.periodic is None:
        return direct
    shorter = direct - space.width * np.rint(direct / space.width)
    return np.where(space.periodic, shorter, direct)


def after_cuts(cuts: NDArray[np.integer[Any]], genes: int) -> NDArray[np.bool_]:
    """Return whether each gene, (pairs, genes), is at or after its pair's cut, (pairs, 1)."""
    narrow = np.min_scalar_type(genes)  # three times as fast as 64-bit integers
    return np.arange(genes, dtype=narrow) >= cuts.astype(narrow)


def exchange(
    mothers: Genomes, fathers: Genomes, swapped: NDArray[np.bool_], children: int
) -> NDArray[Any]:
    """Return copies of the mothers, then of the fathers, after exchanging some of their genes.

    Args:
        mothers: genomes, (pairs, genes).
        fathers: genomes, (pairs, genes).
        swapped: whether parents exchange each gene, broadcast to (pairs, genes).
        children: number of children per pair, 1 or 2.

    Returns:
        All first children, then all second children, (pairs × children, genes).
    """
    crossed = np.stack((mothers, fathers)[:children])
    # Flip the bits that differ: ten times as fast as np.where for genomes of bits.
    unsigned = f"u{crossed.itemsize}"
    bits = crossed.view(unsigned)
    bits ^= (mothers.view(unsigned) ^ fathers.view(unsigned)) * swapped
    return crossed.reshape(-1, mothers.shape[1])


class SinglePoint(Crossover):
    """Takes the mother's genes before a cut and the father's genes after it.

    Holland 1975. A second child gets the other genes.
    """

    children: Literal[1, 2] = option(1, "number of children of each pair of parents")
    point: Literal["random", "half"] = option(
        "random",
        "position of the cut: 'random' draws it for each pair, 'half' always cuts in the middle",
    )

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each.

        A single gene comes from the mother.
        """
        pairs, genes = mothers.shape
        if genes == 1:
            cuts = np.ones((pairs, 1), dtype=np.int64)
        elif self.point == "half":
            cuts = np.full((pairs, 1), genes // 2)
        else:
            cuts = rng.integers(1, genes, (pairs, 1))
        return exchange(mothers, fathers, after_cuts(cuts, genes), self.children)


class TwoPoint(Crossover):
    """Takes the father's genes between two cuts, and the mother's genes on both sides.

    De Jong 1975. A second child gets the other genes. The two cuts differ, and all pairs of cuts
    are equally likely.
    """

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each.

        Two genes have room for only one cut, so the second comes from the father. A single gene
        comes from the mother.
        """
        pairs, genes = mothers.shape
        if genes < 3:
            return exchange(mothers, fathers, np.arange(genes) >= 1, self.children)
        one, other = distinct_pairs(genes - 1, (pairs, 1), rng)
        # Genes between the cuts are past exactly one of them, in either order of the cuts.
        return exchange(
            mothers,
            fathers,
            after_cuts(one + 1, genes) != after_cuts(other + 1, genes),
            self.children,
        )


class Uniform(Crossover):
    """Takes each gene from the father with a given probability, otherwise from the mother.

    Syswerda 1989; with a probability other than one half, Spears and De Jong 1991. A second child
    gets the other genes.
    """

    probability: float = option(
        0.5, "probability that a gene is exchanged between the parents", ge=0, le=1
    )

    portable: ClassVar[bool] = True

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes), of parents, (pairs, genes) each."""
        swapped = rng.random(mothers.shape) < self.probability
        return exchange(mothers, fathers, swapped, self.children)


class Blend(Crossover):
    """Draws each gene of a child uniformly between its parents' genes, extended by α on both sides.

    BLX-α, Eshelman and Schaffer 1993. With α = 0.5, the spread of genes neither shrinks nor grows
    much from generation to generation. Children are drawn independently. Periodic genes lie between
    their parents on the shorter way round.
    """

    alpha: float = option(
        0.5, "extension beyond the parents, as a share of their distance", ge=0, le=10
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes) float64, of parents, (pairs, genes) each."""
        difference = parent_differences(mothers, fathers, real_space(space))
        share = uniform(rng, -self.alpha, 1 + self.alpha, (self.children, *difference.shape))
        return (mothers + share * difference).reshape(-1, difference.shape[1])


class SimulatedBinary(Crossover):
    """Places two children symmetrically about the middle of their parents, mostly near the parents.

    SBX, Deb and Agrawal 1995, without bounds. For each gene, a random child gets the lower value,
    as in Deb's own programs; otherwise each child would nearly copy one parent. Those programs
    cross half of the genes of a pair: `gene_probability = 0.5`. The middle of periodic genes is on
    the shorter way round.
    """

    eta: float = option(
        15.0,
        "distribution index; larger values keep children closer to their parents",
        ge=0,
        le=1000,
    )

    gene_probability: float = option(
        1.0,
        "probability that a gene of a crossed pair is crossed; otherwise each child inherits the "
        "gene of one parent",
        ge=0,
        le=1,
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return children, (pairs × children, genes) float64, of parents, (pairs, genes) each.

        The mean of both children equals the mean of their parents. With one child per pair, the
        second is dropped.
        """
        difference = parent_differences(mothers, fathers, real_space(space))
        # One draw gives the side, by the half of its range, and the position in that half.
        draws = 2 * rng.random(difference.shape)
        swapped = draws >= 1
        spread = _spread_factor(draws - swapped, self.eta)
        part = (1 - np.where(swapped, -spread, spread)) / 2
        children = [mothers + share * difference for share in (part, 1 - part)[: self.children]]
        if self.gene_probability < 1:
            kept = rng.random(difference.shape) >= self.gene_probability
            for child, parents in zip(children, (mothers, fathers), strict=False):
                np.copyto(child, parents, where=kept)
        return np.concatenate(children)


def _spread_factor(uniform: NDArray[np.float64], eta: float) -> NDArray[np.float64]:
    """Return the children's distance relative to the parents' distance, for draws from [0, 1)."""
    base = np.where(uniform <= 0.5, 2 * uniform, 0.5 / (1 - uniform))
    return power(base, 1 / (eta + 1))


class NoCrossover(Crossover):
    """Copies parents unchanged, for schemes that breed by mutation alone.

    With two children, the first is a copy of the mother and the second of the father.
    """

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (GenomeSpace,)
    pair_probability: ClassVar[float] = 1.0  # type: ignore[misc]  # not an option of this class

    def cross(
        self, mothers: Genomes, fathers: Genomes, space: GenomeSpace, rng: np.random.Generator
    ) -> Genomes:
        """Return copies, (pairs × children, genes), of parents, (pairs, genes) each."""
        return mothers.copy() if self.children == 1 else np.concatenate((mothers, fathers))
