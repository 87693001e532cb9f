"""Components of a channel: chosen by name or index, and laid out as lines."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, nearest
from gaitsim.render.plots.channels import Channel

MANY_TRIALS = 7


@dataclass(frozen=True, eq=False)
class Line:
    """One component over time.

    Attributes:
        names: along each axis of the channel that has several entries.
        values: (frames,).
    """

    names: tuple[str, ...]
    values: NDArray[Any]

    @property
    def name(self) -> str:
        """Its names in one."""
        return " ".join(self.names)


def lines_of(channel: Channel, components: Sequence[str]) -> list[Line]:
    """The components that are asked for, in the channel's order.

    Args:
        channel: what they are of.
        components: names or, along the last axis, indices from 0. Those of one axis add
            up; an axis of which none is named is taken whole, if it is not of many trials.

    Raises:
        GaitsimError: there is no such component; all there are are listed.
    """
    chosen: list[set[int]] = [set() for _ in channel.axes]
    for component in components:
        axis, index = _found(channel, component)
        chosen[axis].add(index)
    ranges = [
        sorted(some) or _usual(names) for some, names in zip(chosen, channel.axes, strict=True)
    ]
    return [
        Line(
            tuple(
                names[index]
                for names, index in zip(channel.axes, indices, strict=True)
                if len(names) > 1
            ),
            np.moveaxis(channel.values, 0, -1)[indices],
        )
        for indices in product(*ranges)
    ]


def _usual(names: Sequence[str]) -> Sequence[int]:
    """All of an axis, but only the first of many trials: they are the same again."""
    return range(1 if names[:1] == ("trial 0",) and len(names) > MANY_TRIALS else len(names))


def _found(channel: Channel, component: str) -> tuple[int, int]:
    """The axis and the index of a component."""
    backwards = [*reversed([*enumerate(channel.axes)])]
    for axis, names in backwards:
        if component in names:
            return axis, names.index(component)
    for axis, names in backwards[:1]:
        if component.isascii() and component.isdigit() and int(component) < len(names):
            return axis, int(component)
    known = [name for _, names in backwards for name in names]
    raise GaitsimError(
        f"the channel {channel.name!r} has no component {component!r}",
        allowed="; and ".join(", ".join(names) for names in channel.axes)
        + f"; or 0 to {len(channel.axes[-1]) - 1} along the last of them"
        if known
        else "none: it is one value a frame",
        remedy=nearest(component, known),
    )


def finite(values: NDArray[Any]) -> NDArray[np.float64]:
    """The same with gaps where a value is not finite."""
    numbers = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(numbers), numbers, np.nan)
