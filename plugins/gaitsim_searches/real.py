"""Arithmetic on genomes of real numbers between bounds, some of which may be periodic."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, GenomeSpace, PluginError, RealSpace


def real_space(space: GenomeSpace) -> RealSpace:
    """Return the space with the type `RealSpace`."""
    if not isinstance(space, RealSpace):
        raise PluginError(
            f"this search does not support genomes of the kind {space.name!r}",
            allowed="genomes of the kind 'real' (real numbers)",
            remedy="choose a search that supports these genomes",
        )
    return space


def differences(to: Genomes, start: Genomes, space: RealSpace) -> NDArray[Any]:
    """Return `to` − `start`; periodic genes take the shorter way round, at most half a width."""
    steps = to - start
    if space.periodic is None:
        return steps
    return np.where(space.periodic, steps - space.width * np.round(steps / space.width), steps)


def halved_past_bounds(moved: Genomes, start: Genomes, space: RealSpace) -> Genomes:
    """Replace genes past a bound by the middle between the bound and their start.

    The population then approaches a bound without piling up on it (Zhang and Sanderson 2009,
    "JADE"). Periodic genes wrap around.
    """
    inside = np.where(moved < space.lower, (space.lower + start) / 2, moved)
    inside = np.where(moved > space.upper, (space.upper + start) / 2, inside)
    if space.periodic is not None:
        inside = np.where(space.periodic, moved, inside)
    return space.repair(inside)
