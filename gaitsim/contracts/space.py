"""Genome spaces: the sets of genomes that bodies accept."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import standard_normal, uniform
from gaitsim.repr_mixin import ReprField, ReprMixin

Genomes = NDArray[Any]
"""Genomes of shape (population, genes), in the dtype of the genome space."""


class GenomeSpace(ReprMixin, ABC):
    """A set of valid genomes, all of the same length and dtype.

    Attributes:
        name: name of the kind of space, such as 'real'.
        dtype: dtype of the genomes.
        labels: name of each gene.
    """

    name: ClassVar[str]
    dtype: ClassVar[np.dtype[Any]]
    labels: tuple[str, ...]

    @property
    def genes(self) -> int:
        """The number of genes in a genome."""
        return len(self.labels)

    @property
    def no_genomes(self) -> Genomes:
        """An empty array of genomes, (0, genes)."""
        return np.empty((0, self.genes), self.dtype)

    @abstractmethod
    def random(self, count: int, rng: np.random.Generator) -> Genomes:
        """Return `count` random genomes, (count, genes)."""

    @abstractmethod
    def repair(self, genomes: Genomes) -> Genomes:
        """Return the genomes with every invalid gene replaced by a valid one."""

    @abstractmethod
    def contains(self, genomes: Genomes) -> bool:
        """Return whether the shape, the dtype and every gene are valid."""

    @abstractmethod
    def diversity(self, genomes: Genomes) -> float:
        """Return a measure of how much the genomes differ, 0 if all are equal.

        It is about 0.29 for uniformly distributed real genes and about 0.5 for random bits.
        """

    def _repr_fields(self) -> Mapping[str, ReprField]:
        labels = ", ".join(self.labels[:3]) + ", …" * (self.genes > 3)
        return {"genes": self.genes, "labels": labels}

    def _has_form(self, genomes: Genomes) -> bool:
        return genomes.ndim == 2 and genomes.shape[1] == self.genes and genomes.dtype == self.dtype


@dataclass(frozen=True, eq=False, repr=False)
class RealSpace(GenomeSpace):
    """Genomes of real numbers between bounds.

    Args:
        lower: smallest value of each gene, (genes,) float64.
        upper: largest value of each gene, (genes,) float64; finite, above `lower`.
        labels: name of each gene; () for 'gene 1', 'gene 2' and so on.
        initial_sigma: standard deviation of the initial population around the middle of the bounds,
            in the unit of the gene, (genes,); None for a uniform distribution between the bounds.
        periodic: whether each gene is periodic, such as a phase, (genes,) bool; None if no gene is.
            A value beyond one bound of a periodic gene wraps around to the other bound.

    Raises:
        ValueError: the shapes differ, or the bounds are not finite and ascending.
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    labels: tuple[str, ...] = ()
    initial_sigma: NDArray[np.float64] | None = None
    periodic: NDArray[np.bool_] | None = None

    name: ClassVar[str] = "real"
    dtype: ClassVar[np.dtype[Any]] = np.dtype(np.float64)

    def __post_init__(self) -> None:
        labels = self.labels or tuple(f"gene {n}" for n in range(1, 1 + np.size(self.lower)))
        object.__setattr__(self, "labels", labels)
        expected = (len(self.labels),)
        for field in ("lower", "upper", "initial_sigma", "periodic"):
            value = getattr(self, field)
            if value is None:
                continue
            dtype = np.bool_ if field == "periodic" else np.float64
            object.__setattr__(self, field, np.asarray(value, dtype))
            if np.shape(value) != expected:
                raise ValueError(
                    f"RealSpace.{field} has shape {np.shape(value)}, expected (genes,) = {expected}"
                )
        if not (np.isfinite(self.lower).all() and np.isfinite(self.upper).all()):
            raise ValueError("RealSpace bounds must be finite")
        if not (self.lower < self.upper).all():
            gene = self.labels[int(np.argmin(self.lower < self.upper))]
            raise ValueError(f"RealSpace.lower must be below RealSpace.upper: see gene {gene!r}")

    @property
    def width(self) -> NDArray[np.float64]:
        """The distance between the bounds of each gene, (genes,)."""
        return self.upper - self.lower

    def random(self, count: int, rng: np.random.Generator) -> Genomes:
        """Return `count` random genomes, (count, genes): Gaussian if `initial_sigma` is given."""
        if self.initial_sigma is None:
            return uniform(rng, self.lower, self.upper, (count, self.genes))
        middle = (self.lower + self.upper) / 2
        return self.repair(middle + self.initial_sigma * standard_normal(rng, (count, self.genes)))

    def repair(self, genomes: Genomes) -> Genomes:
        """Clip genes to their bounds; wrap periodic genes."""
        clipped = np.clip(genomes, self.lower, self.upper)
        if self.periodic is None:
            return clipped
        wrapped = self.lower + np.mod(genomes - self.lower, self.width)
        outside = (genomes < self.lower) | (genomes > self.upper)
        # lower + mod(…) may round up past upper by one bit.
        return np.where(self.periodic & outside, np.minimum(wrapped, self.upper), clipped)

    def contains(self, genomes: Genomes) -> bool:
        """Return whether the shape and dtype are valid and every gene is within its bounds."""
        return self._has_form(genomes) and bool(
            ((genomes >= self.lower) & (genomes <= self.upper)).all()
        )

    def diversity(self, genomes: Genomes) -> float:
        """Return the standard deviation of a gene relative to its range, averaged over genes."""
        # The bits of np.mean(np.std(…)), in a third of the time.
        away = genomes - np.add.reduce(genomes, axis=0) / len(genomes)
        deviations = np.sqrt(np.add.reduce(away * away, axis=0) / len(genomes))
        return float(np.add.reduce(deviations / self.width) / self.genes)


@dataclass(frozen=True, eq=False, repr=False)
class BitSpace(GenomeSpace):
    """Genomes of bits, each 0 or 1 as uint8.

    Args:
        labels: name of each bit.
        repair_bits: function that replaces invalid bit patterns with valid ones,
            (population, genes) -> (population, genes); None if all patterns are valid.
    """

    labels: tuple[str, ...]
    repair_bits: Callable[[Genomes], Genomes] | None = None

    name: ClassVar[str] = "bit"
    dtype: ClassVar[np.dtype[Any]] = np.dtype(np.uint8)

    def random(self, count: int, rng: np.random.Generator) -> Genomes:
        """Return `count` repaired genomes of random, equally likely bits, (count, genes)."""
        # The same bits as from rng.integers, in a third of the time.
        drawn = np.frombuffer(rng.bytes(count * self.genes), np.uint8) >> 7
        return self.repair(drawn.reshape(count, self.genes))

    def repair(self, genomes: Genomes) -> Genomes:
        """Replace invalid bit patterns with valid ones."""
        return genomes if self.repair_bits is None else self.repair_bits(genomes)

    def contains(self, genomes: Genomes) -> bool:
        """Return whether the genomes are valid bits, which `repair` does not change."""
        if not (self._has_form(genomes) and (genomes <= 1).all()):
            return False
        repaired = self.repair(genomes)
        return repaired is genomes or bool((repaired == genomes).all())

    def diversity(self, genomes: Genomes) -> float:
        """Return the mean standard deviation of the bits: about 0.5 for random bits."""
        return float(np.mean(np.std(genomes, axis=0)))
