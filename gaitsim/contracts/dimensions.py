"""Dimensions of bodies, such as the length of a shank: set by options, or genes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.motion import Channel, Measure, Motion
from gaitsim.errors import GaitsimError, unknown

DIMENSIONS_HELP = (
    "factors of the body's dimensions by name, such as { shank = 1.15 }; the others are 1"
)
EVOLVE_HELP = "names of the body's dimensions that are genes, such as shank"
RANGES_HELP = (
    "smallest and largest factors of dimensions that evolve, by name, such as { shank = [0.8, 1.5] "
    "}; 0.7 to 1.3 by default"
)


@dataclass(frozen=True)
class Dimension:
    """A length, a position or another size of a body, which a factor changes.

    Attributes:
        unit: unit of the nominal value.
        nominal: value with a factor of 1.
        help: description of the dimension, one phrase.
        low: lower end of the usual range of the factor.
        high: upper end of the usual range of the factor.
        least: smallest factor that the body supports.
        most: largest factor that the body supports.
    """

    unit: str
    nominal: float
    help: str
    low: float = 0.7
    high: float = 1.3
    least: float = 0.2
    most: float = 5.0


def check_dimensions(
    space: Mapping[str, Dimension],
    dimensions: Mapping[str, float],
    evolve: Sequence[str],
    ranges: Mapping[str, Sequence[float]],
) -> None:
    """Validate the options `dimensions`, `evolve` and `ranges` of a body.

    Args:
        space: dimensions of the body by name.
        dimensions: factors by name.
        evolve: names of the dimensions that are genes.
        ranges: smallest and largest factors of such dimensions by name.

    Raises:
        GaitsimError: a name is unknown or listed twice, a factor is outside the range that the body
            supports, a range is empty, or a dimension is both set and evolved.
    """
    for key, names in (("dimensions", dimensions), ("evolve", evolve)):
        for name in names:
            if name not in space:
                raise unknown("dimension", name, [*space], key=key)
    for name, factor in dimensions.items():
        _check_factor(space[name], name, factor, "dimensions")
        if name in evolve:
            raise GaitsimError(
                f"the dimension {name!r} is both set and evolved",
                key="dimensions",
                remedy=f"remove {name} from organism.dimensions or from organism.evolve; "
                "organism.ranges sets the range of a dimension that evolves",
            )
    for name, (low, high) in ranges.items():
        if name not in evolve:
            raise unknown("dimension that evolves:", name, [*evolve], key="ranges")
        for factor in (low, high):
            _check_factor(space[name], name, factor, "ranges")
        if low >= high:
            raise GaitsimError(
                f"the range of the dimension {name!r} is empty: {low:g} to {high:g}",
                key="ranges",
                allowed="the smaller factor first",
            )
    if len({*evolve}) < len(evolve):
        twice = next(name for name in evolve if list(evolve).count(name) > 1)
        raise GaitsimError(
            f"a dimension is listed twice: {twice}", key="evolve", allowed="each name at most once"
        )


def _check_factor(dimension: Dimension, name: str, factor: float, key: str) -> None:
    if not dimension.least <= factor <= dimension.most:
        raise GaitsimError(
            f"invalid factor of the dimension {name!r}: {factor:g}",
            key=key,
            allowed=f"{dimension.least:g} to {dimension.most:g}; 1 is {dimension.nominal:.3g} "
            f"{dimension.unit}".rstrip(),
        )


def dimension_measures(names: Sequence[str], motion: Motion) -> dict[str, Measure]:
    """Return the factors of dimensions that evolve as measures, such as axes of an archive.

    Args:
        names: names of the dimensions.
        motion: motion with the channel `dimensions`, (population, dimensions).
    """
    return {
        f"{name} factor": Measure(motion["dimensions"][:, index], "", f"factor of {name}")
        for index, name in enumerate(names)
    }


def factor_bounds(
    space: Mapping[str, Dimension], evolve: Sequence[str], ranges: Mapping[str, Sequence[float]]
) -> NDArray[np.float64]:
    """Return the smallest and largest factors of the dimensions that evolve, (2, dimensions)."""
    usual = [ranges.get(name, (space[name].low, space[name].high)) for name in evolve]
    return np.array(usual, np.float64).reshape(-1, 2).T


class EvolvingChannels:
    """The channels of a body whose dimensions may evolve: `ClassVar[Any] = EvolvingChannels(…)`.

    A body whose option `evolve` lists dimensions also has the channel `dimensions`, from which
    `skeleton` knows the body of each individual; so has its class, which shows all channels.

    Args:
        channels: the other channels by name.
    """

    def __init__(self, channels: Mapping[str, Channel]) -> None:
        self._channels = channels

    def __get__(self, body: Any, owner: type) -> Mapping[str, Channel]:
        if body is not None and not body.evolve:
            return self._channels
        evolved = Channel(("dimensions",), "", "factors of the dimensions that evolve")
        return {**self._channels, "dimensions": evolved}
