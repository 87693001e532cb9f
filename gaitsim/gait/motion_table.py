"""All channels of the motions of individuals, as columns of a table or as arrays."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.channels import check_numbers, count_trials, entries_of, read_values
from gaitsim.individual import Individual
from gaitsim.registry import contract_error

Columns = dict[str, NDArray[Any]]


def motion_columns(
    individuals: Iterable[Individual], places: Sequence[Mapping[str, int]] = ()
) -> Columns:
    """Return the motions as columns, with a row for each frame of each trial of an individual.

    The first columns say where a row belongs: `generation`, `member` or `individual`, `score`,
    `trial`, `frame` and `time (s)`. Each further column is an entry of a channel with its unit,
    such as `feet L1 x (m)`. A channel that has one value per gait has it in all rows.

    Args:
        individuals: individuals of any bodies; columns that a body does not have are NaN.
        places: further columns that tell the individuals apart, with a value for each individual.
    """
    parts = [
        _columns_of(one, places[index] if places else {}) for index, one in enumerate(individuals)
    ]
    names = dict.fromkeys(name for part in parts for name in part)
    rows = [len(part["frame"]) for part in parts]
    return {
        name: np.concatenate(
            [
                part[name] if name in part else np.full(count, np.nan)
                for part, count in zip(parts, rows, strict=True)
            ]
        )
        for name in names
    }


def _columns_of(individual: Individual, place: Mapping[str, int]) -> Columns:
    """Return the columns of one individual, with the rows of each trial in turn."""
    channels = individual.experiment.organism.channels
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
    found: Columns = {"generation": np.full(rows, individual.generation)}
    if individual.member is not None:
        found["member"] = np.full(rows, individual.member.number)
    found |= {name: np.full(rows, value) for name, value in place.items()}
    found["score"] = np.full(rows, individual.score)
    if trials > 1:
        found["trial"] = np.repeat(np.arange(1, trials + 1), frames)
    found["frame"], found["time (s)"] = frame, frame / individual.motion.frame_rate
    for name, channel in channels.items():
        check_numbers(individual, name, values[name])
        entries = entries_of(individual, channel, values[name].shape)
        axes = [axis for axis in channel.axes if axis != "frames"]
        inner = [names for axis, names in zip(axes, entries, strict=True) if axis != "trials"]
        table = _by_row(values[name], channel.axes, trials, frames)
        for index, labels in enumerate(product(*inner)):
            # Units differ only along the last axis.
            unit = channel.unit_of(index % len(inner[-1]) if inner else 0)
            label = " ".join((name, *labels))
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


def motion_arrays(
    individuals: Sequence[Individual], places: Sequence[Mapping[str, int]] = ()
) -> tuple[Columns, dict[str, Any]]:
    """Return the motions as arrays by channel, each (individuals, …), and their description.

    The description has the frame rate, and the axes, unit and meaning of each channel. The arrays
    `generation`, `member` or `individual`, and `score` are (individuals,); `time`, in seconds, is
    (frames,).

    Raises:
        GaitsimError: the motions have different shapes.
    """
    first = individuals[0]
    channels = first.experiment.organism.channels
    found: Columns = {"generation": np.array([one.generation for one in individuals])}
    if first.member is not None:
        found["member"] = np.array([one.member.number if one.member else 0 for one in individuals])
    for name in places[0] if places else ():
        found[name] = np.array([place[name] for place in places])
    found["score"] = np.array([one.score for one in individuals])
    about: dict[str, Any] = {}
    frames = 1
    for name, channel in channels.items():
        each = [read_values(one, name) for one in individuals]
        check_numbers(first, name, each[0])
        if len({values.shape for values in each}) > 1:
            raise GaitsimError(
                f"the channel {name!r} has different shapes for different individuals",
                allowed=".csv and .parquet, which have a row for each frame",
            )
        found[name] = np.stack(each)
        frames = len(each[0]) if channel.over_time else frames
        names = iter(entries_of(first, channel, each[0].shape))
        axes = ["frame" if axis == "frames" else [*next(names)] for axis in channel.axes]
        unit = channel.unit if isinstance(channel.unit, str) else [*channel.unit]
        about[name] = {"axes": ["individual", *axes], "unit": unit, "meaning": channel.help}
    rate = first.motion.frame_rate
    found["time"] = np.arange(frames) / rate
    return found, {"frame_rate": rate, "channels": about}
