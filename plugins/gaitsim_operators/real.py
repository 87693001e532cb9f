"""Operators that need an order and a scale of genes work on real numbers alone."""

from gaitsim.contracts import GenomeSpace, RealSpace
from gaitsim.errors import PluginError


def real(space: GenomeSpace) -> RealSpace:
    """Return the space, typed as one of real numbers.

    Raises:
        PluginError: the space is of another kind.
    """
    if not isinstance(space, RealSpace):
        raise PluginError(
            f"this operator cannot work on genomes of the {space.name} space",
            allowed="genomes of the real space",
            remedy="choose an operator whose `spaces` has that kind",
        )
    return space
