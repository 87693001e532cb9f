"""Arithmetic on genomes of real numbers between bounds, some of which are angles of a cycle."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace, RealSpace
from gaitsim.errors import PluginError


def real(space: GenomeSpace) -> RealSpace:
    """Return the space, typed as one of real numbers.

    Raises:
        PluginError: the space is of another kind.
    """
    if not isinstance(space, RealSpace):
        raise PluginError(
            f"this search cannot work on genomes of the {space.name} space",
            allowed="genomes of the real space",
            remedy="choose a search whose `spaces` has that kind",
        )
    return space


def differences(to: Genomes, start: Genomes, space: RealSpace) -> NDArray[Any]:
    """Return `to` − `start`, of periodic genes the shorter way around, at most half a width."""
    steps = to - start
    if space.periodic is None:
        return steps
    return np.where(space.periodic, steps - space.width * np.round(steps / space.width), steps)


def halved_past_bounds(moved: Genomes, start: Genomes, space: RealSpace) -> Genomes:
    """Bring genes back into the space: past a bound, halfway between it and where they started.

    Zhang & Sanderson 2009 (JADE). The population then comes close to a bound without piling up on
    it. Periodic genes wrap around.
    """
    inside = np.where(moved < space.lower, (space.lower + start) / 2, moved)
    inside = np.where(moved > space.upper, (space.upper + start) / 2, inside)
    if space.periodic is not None:
        inside = np.where(space.periodic, moved, inside)
    return space.repair(inside)
