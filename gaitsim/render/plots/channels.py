"""The channels of one individual's motion as signals over time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError, nearest
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors


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


def read_values(individual: Individual, name: str) -> NDArray[Any]:
    """Return a channel of the individual, without the axis of the population."""
    experiment = individual.experiment
    entry, channels = experiment.entries["organism"], experiment.organism.channels
    if name not in channels:
        raise GaitsimError(
            f"{entry} has no channel {name!r}",
            where=str(individual.source),
            allowed="".join(f"\n    {one}: {channel}" for one, channel in channels.items()),
            remedy=nearest(name, [*channels]),
        )
    with plugin_errors(entry, f"computing the channel {name!r}"):
        values = np.asarray(individual.motion[name])
    if values.shape[:1] != (1,) or not channels[name].fits(values.shape):
        raise contract_error(
            entry,
            f"returned the channel {name!r} with the shape {values.shape} for one individual",
            channels[name].shape,
        )
    one: NDArray[Any] = values[0]
    return one


def count_trials(individual: Individual) -> int:
    """Return the number of trials of the individual; its skeleton shows the first."""
    for name, channel in individual.experiment.organism.channels.items():
        if "trials" in channel.axes:
            return int(read_values(individual, name).shape[channel.axes.index("trials")])
    return 1


def read_signal(individual: Individual, name: str) -> Signal:
    """Return a channel of the individual over time, with names for all entries."""
    organism, entry = individual.experiment.organism, individual.experiment.entries["organism"]
    values = read_values(individual, name)
    channel = organism.channels[name]
    if values.dtype.kind not in "biuf":
        raise contract_error(
            entry,
            f"returned the channel {name!r} as {values.dtype}",
            "real numbers or truth values",
        )
    if not channel.over_time:
        timed = [one for one, other in organism.channels.items() if other.over_time]
        raise GaitsimError(
            f"the channel {name!r} of {entry} has one value per gait, not one per frame",
            allowed=", ".join(timed) or "none, because this body has no channel over time",
        )
    with plugin_errors(entry, "naming its joints"):
        names = {"joints": tuple(map(str, organism.joint_names()))}
    names["feet"] = individual.skeleton.contact_names
    entries = tuple(
        _entries(axis, length, names)
        for axis, length in zip(channel.axes[1:], values.shape[1:], strict=True)
    )
    return Signal(name, channel, values, entries, individual.motion.frame_rate)


def _entries(
    axis: str | tuple[str, ...], length: int, names: Mapping[str, tuple[str, ...]]
) -> tuple[str, ...]:
    """Return the names along one axis, from the declaration or the body, or else numbered."""
    if isinstance(axis, tuple):
        return axis
    if len(names.get(axis, ())) == length:
        return names[axis]
    one = "trial" if axis == "trials" else axis
    return tuple(f"{one} {entry}" for entry in range(1, length + 1))
