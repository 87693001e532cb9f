"""The channels of a motion as signals over time, and their components as lines."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError, nearest
from gaitsim.gait.channels import channels_of, entries_of, read_values
from gaitsim.individual import Individual

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_TRIALS = 7  # maximum number of trials drawn; of more trials, only the first is drawn


@dataclass(frozen=True, eq=False)
class Signal:
    """One channel of one individual over time.

    Attributes:
        name: name of the channel.
        channel: declaration of the channel.
        values: values over time, (frames, …).
        entries: names of the entries along each axis except time.
        rate: frames per second, Hz.
    """

    name: str
    channel: Channel
    values: NDArray[Any]
    entries: tuple[tuple[str, ...], ...]
    rate: float


def read_signal(individual: Individual, name: str) -> Signal:
    """Return a channel of the individual over time, with names for all entries."""
    values, channels = read_values(individual, name), channels_of(individual)
    channel = channels[name]
    if not channel.over_time:
        entry = individual.experiment.entries["organism"]
        timed = [one for one, other in channels.items() if other.over_time]
        raise GaitsimError(
            f"the channel {name!r} of {entry} has one value per gait, not one per frame",
            allowed=", ".join(timed) or "none, because this body has no channel over time",
        )
    entries = entries_of(individual, channel, values.shape)
    return Signal(name, channel, values, entries, individual.motion.frame_rate)


@dataclass(frozen=True, eq=False)
class Line:
    """One component over time.

    Attributes:
        names: name of the entry along each axis of the channel that has several entries.
        values: values of the component, (frames,).
        unit: unit of the values, '' for a pure number.
    """

    names: tuple[str, ...]
    values: NDArray[Any]
    unit: str

    @property
    def name(self) -> str:
        """The names, joined."""
        return " ".join(self.names)


def lines_of(signal: Signal, components: Sequence[str]) -> list[Line]:
    """Return the chosen components as lines, in the order of the channel.

    Args:
        signal: the channel of an individual.
        components: names, or numbers along the last axis, counted from 1. All entries of an axis
            are drawn unless some of them are chosen.
    """
    # If there are many trials, only the first is drawn, as the others look similar.
    chosen: list[set[int]] = [set() for _ in signal.entries]
    for component in components:
        axis, index = _find(signal, component)
        chosen[axis].add(index)
    ranges = [
        sorted(some) or range(1 if axis == "trials" and len(names) > MAX_TRIALS else len(names))
        for some, axis, names in zip(chosen, signal.channel.axes[1:], signal.entries, strict=True)
    ]
    return [
        Line(
            tuple(
                names[index]
                for names, index in zip(signal.entries, indices, strict=True)
                if len(names) > 1
            ),
            np.moveaxis(signal.values, 0, -1)[indices],
            signal.channel.unit_of(indices[-1] if indices else 0),
        )
        for indices in product(*ranges)
    ]


def _find(signal: Signal, component: str) -> tuple[int, int]:
    """Return the axis and the index of a component."""
    backwards = [*reversed([*enumerate(signal.entries)])]
    for axis, names in backwards:
        if component in names:
            return axis, names.index(component)
    for axis, names in backwards[:1]:
        if component.isascii() and component.isdigit() and 1 <= int(component) <= len(names):
            return axis, int(component) - 1
    known = [name for _, names in backwards for name in names]
    raise GaitsimError(
        f"the channel {signal.name!r} has no component {component!r}",
        allowed="; and ".join(", ".join(names) for names in signal.entries)
        + f"; or a number from 1 to {len(signal.entries[-1])} along the last axis"
        if known
        else "none, because the channel has one value per frame",
        remedy=nearest(component, known),
    )


_SMALL = 0.1  # m; lengths that are all smaller are shown in millimetres
_NOISE = 1e-9  # values of smaller magnitude are rounding errors of zero


def shown_unit(unit: str, values: NDArray[np.float64] | None = None) -> tuple[float, str]:
    """Return the unit in which to show values, and the factor to convert to it.

    Angles are shown in degrees, and lengths in millimetres if all given values are small.
    """
    if unit.startswith("rad"):
        return 180 / np.pi, unit.replace("rad", "°")
    if unit == "m" and values is not None and np.nanmax(np.abs(values), initial=0.0) < _SMALL:
        return 1000.0, "mm"
    return 1.0, unit


def limit_constant(axes: "Axes", values: NDArray[np.float64]) -> None:
    """Limit the vertical axis of a line that is zero throughout to −1 to 1."""
    if np.nanmax(np.abs(values), initial=0.0) < _NOISE:
        axes.set_ylim(-1, 1)


def finite_or_nan(values: NDArray[Any]) -> NDArray[np.float64]:
    """Return the values, with those that are not finite as NaN, which leaves a gap in a line."""
    numbers = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(numbers), numbers, np.nan)
