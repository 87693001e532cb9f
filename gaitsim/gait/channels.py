"""The channels of one individual's motion: their values, the names of their entries, a table."""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError, nearest
from gaitsim.individual import Individual, Member
from gaitsim.registry import contract_error, plugin_errors

Columns = dict[str, NDArray[Any]]

_TAKEN = ["generation", "member", "individual", "score", "trial", "frame", "time", "about", "file"]


def channels_of(individual: Individual) -> Mapping[str, Channel]:
    """Return the declared channels, or those of the motion of a body that declares none."""
    return individual.body.channels or {
        name: Channel(("entry",) * (np.ndim(values) - 1), "", "returned by the body")
        for name, values in individual.motion.items()
    }


def read_values(individual: Individual, name: str) -> NDArray[Any]:
    """Return a channel of the individual, without the axis of the population.

    Raises:
        GaitsimError: the body has no such channel.
        PluginError: the channel cannot be computed, or does not hold numbers or truth values of
            the declared shape.
    """
    entry, channels = individual.experiment.entries["organism"], channels_of(individual)
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
    if values.dtype.kind not in "biuf":
        raise contract_error(
            entry,
            f"returned the channel {name!r} as {values.dtype}",
            "real numbers or truth values",
        )
    one: NDArray[Any] = values[0]
    return one


def count_trials(individual: Individual) -> int:
    """Return the number of trials of the individual; its skeleton shows the first."""
    for name, channel in individual.body.channels.items():
        if "trials" in channel.axes:
            return int(read_values(individual, name).shape[channel.axes.index("trials")])
    return 1


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
    organism, entry = individual.body, individual.experiment.entries["organism"]
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


def place_of(individual: Individual, number: int | None) -> dict[str, int | float]:
    """Return the numbers that tell an individual of a run apart, and its score.

    Args:
        individual: individual of any body.
        number: number of the individual in the population of its generation, if it is known.
    """
    found: dict[str, int | float] = {"generation": individual.generation}
    if isinstance(individual.member, Member):
        found["member"] = individual.member.number
    elif individual.member is not None:
        number = individual.member.number
    if number is not None:
        found["individual"] = number
    return {**found, "score": individual.score}


def own_name(name: str) -> str:
    """Return the name of a channel in files, unlike those of their further columns and arrays."""
    return f"channel {name}" if name in _TAKEN else name


def motion_columns(individual: Individual, number: int | None = None) -> Columns:
    """Return a motion as columns, with a row for each frame of each trial.

    The first columns say where a row belongs: those of `place_of`, `trial`, `frame` and `time (s)`.
    Each further column is an entry of a channel with its unit, such as `feet L1 x (m)`. A channel
    that has one value per gait has it in all rows.

    Args:
        individual: individual of any body.
        number: number of the individual in the population of its generation, if it is known.
    """
    channels = channels_of(individual)
    values = {name: read_values(individual, name) for name in channels}
    lengths = {len(values[name]) for name, one in channels.items() if one.over_time} or {1}
    if len(lengths) > 1:
        raise contract_error(
            individual.experiment.entries["organism"],
            f"returned channels over time with {sorted(lengths)} frames",
            "the same number of frames in all channels over time",
        )
    frames, trials = lengths.pop(), count_trials(individual)
    rows = trials * frames
    frame = np.tile(np.arange(frames), trials)
    found: Columns = {
        name: np.full(rows, value) for name, value in place_of(individual, number).items()
    }
    if trials > 1:
        found["trial"] = np.repeat(np.arange(1, trials + 1), frames)
    found["frame"], found["time (s)"] = frame, frame / individual.motion.frame_rate
    for name, channel in channels.items():
        entries = entries_of(individual, channel, values[name].shape)
        axes = [axis for axis in channel.axes if axis != "frames"]
        inner = [names for axis, names in zip(axes, entries, strict=True) if axis != "trials"]
        table = _by_row(values[name], channel.axes, trials, frames)
        for index, labels in enumerate(product(*inner)):
            # Units differ only along the last axis.
            unit = channel.unit_of(index % len(inner[-1]) if inner else 0)
            label = " ".join((own_name(name), *labels))
            found[f"{label} ({unit})" if unit else label] = table[:, index]
    return found


def _by_row(
    values: NDArray[Any], axes: tuple[str | tuple[str, ...], ...], trials: int, frames: int
) -> NDArray[Any]:
    """Return a channel as (trials · frames, entries); missing axes are repeated."""
    order = [axes.index(axis) for axis in ("trials", "frames") if axis in axes]
    moved = np.moveaxis(values, order, range(len(order)))
    for position, axis in enumerate(("trials", "frames")):
        if axis not in axes:
            moved = np.expand_dims(moved, position)
    rest = moved.shape[2:]
    return np.broadcast_to(moved, (trials, frames, *rest)).reshape(trials * frames, -1)
