"""Groups of genes: build the genome space of a body, and split genomes into their values."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.contracts import Genomes, RealSpace


@dataclass(frozen=True)
class GeneGroup:
    """Genes that set the same quantity for several parts of a body.

    Attributes:
        name: name of the quantity, such as 'amplitude'.
        parts: part that each gene belongs to, such as 'L1 coxa'; '' for the whole body.
        lower: smallest value, one for all parts or (parts,).
        upper: largest value, one for all parts or (parts,).
        periodic: whether the values are angles of a cycle; see `RealSpace`.
        mirror: offset between the two sides of the body, such as π for the phase of an
            alternating gait. Each part in `parts` then has a counterpart on the other side without
            a gene, whose value is that of the part plus `mirror`. None for a body in which every
            part has its own gene.
    """

    name: str
    parts: tuple[str, ...]
    lower: ArrayLike
    upper: ArrayLike
    periodic: bool = False
    mirror: float | None = None

    def halved(self, mirror: float) -> "GeneGroup":
        """Return the group with genes for the first half of its parts, which the rest mirror."""
        return replace(self, parts=self.parts[: len(self.parts) // 2], mirror=mirror)


def genome_space(groups: Sequence[GeneGroup]) -> RealSpace:
    """Return the space of genomes that hold the groups in order.

    Raises:
        ValueError: a lower bound is not below its upper bound, or bounds are not finite or do not
            match the parts.
    """
    count = [len(group.parts) for group in groups]
    return RealSpace(
        lower=_bounds_by_gene([group.lower for group in groups], count),
        upper=_bounds_by_gene([group.upper for group in groups], count),
        labels=tuple(f"{part} {group.name}".strip() for group in groups for part in group.parts),
        periodic=np.repeat([group.periodic for group in groups], count),
    )


def split_genomes(genomes: Genomes, groups: Sequence[GeneGroup]) -> tuple[NDArray[np.float64], ...]:
    """Return the values of each group, (population, parts), mirrored parts last.

    Args:
        genomes: genomes in `genome_space(groups)`, (population, genes).
        groups: groups in the order of the genome.

    Raises:
        ValueError: the number of genes does not match the groups.
    """
    ends = np.cumsum([len(group.parts) for group in groups])
    if genomes.ndim != 2 or genomes.shape[1] != ends[-1]:
        raise ValueError(
            f"genomes have the shape {genomes.shape}, expected (population, {ends[-1]})"
        )
    return tuple(
        values if group.mirror is None else np.hstack([values, values + group.mirror])
        for group, values in zip(groups, np.split(genomes, ends[:-1], axis=1), strict=True)
    )


def _bounds_by_gene(bounds: Sequence[ArrayLike], counts: Sequence[int]) -> NDArray[np.float64]:
    return np.concatenate(
        [
            np.broadcast_to(np.asarray(bound, np.float64), count)
            for bound, count in zip(bounds, counts, strict=True)
        ]
    )
