"""The channels of one individual's motion: their values, and the names of their entries."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError, nearest
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors


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


def check_numbers(individual: Individual, name: str, values: NDArray[Any]) -> None:
    """Check that a channel holds real numbers or truth values."""
    if values.dtype.kind not in "biuf":
        raise contract_error(
            individual.experiment.entries["organism"],
            f"returned the channel {name!r} as {values.dtype}",
            "real numbers or truth values",
        )


def entries_of(
    individual: Individual, channel: Channel, shape: tuple[int, ...]
) -> tuple[tuple[str, ...], ...]:
    """Return the names of the entries along each axis of a channel, except time.

    They come from the declaration or from the body; other entries are numbered.

    Args:
        individual: individual whose body names its joints and feet.
        channel: declaration of the channel.
        shape: shape of the channel's values for one individual.
    """
    organism, entry = individual.experiment.organism, individual.experiment.entries["organism"]
    names: dict[str, tuple[str, ...]] = {}
    if "joints" in channel.axes:
        with plugin_errors(entry, "naming its joints"):
            names["joints"] = tuple(map(str, organism.joint_names()))
    if "feet" in channel.axes:
        names["feet"] = individual.skeleton.contact_names
    return tuple(
        _entries(axis, length, names.get(axis, ()) if isinstance(axis, str) else axis)
        for axis, length in zip(channel.axes, shape, strict=True)
        if axis != "frames"
    )


def _entries(axis: str | tuple[str, ...], length: int, names: tuple[str, ...]) -> tuple[str, ...]:
    if len(names) == length:
        return names
    one = "trial" if axis == "trials" else axis
    return tuple(f"{one} {entry}" for entry in range(1, length + 1))
