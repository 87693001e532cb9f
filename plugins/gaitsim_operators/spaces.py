"""A check for operators that support only real genes, because they need an order and a scale."""

from gaitsim.contracts import GenomeSpace, RealSpace
from gaitsim.errors import PluginError


def real_space(space: GenomeSpace) -> RealSpace:
    """Return the space with the type `RealSpace`."""
    if not isinstance(space, RealSpace):
        raise PluginError(
            f"this operator does not support genomes of the kind {space.name!r}",
            allowed="genomes of the kind 'real' (real numbers)",
            remedy="choose an operator that supports these genomes",
        )
    return space
