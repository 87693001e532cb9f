"""All channels of motions, as columns of a table or as arrays."""

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.channels import check_numbers, count_trials, entries_of, read_values
from gaitsim.individual import Individual
from gaitsim.registry import contract_error

Columns = dict[str, NDArray[Any]]
Place = Mapping[str, int]


def motion_columns(individual: Individual, place: Place | None = None) -> Columns:
    """Return a motion as columns, with a row for each frame of each trial.

    The first columns say where a row belongs: `generation`, `member` or those of `place`, `score`,
    `trial`, `frame` and `time (s)`. Each further column is an entry of a channel with its unit,
    such as `feet L1 x (m)`. A channel that has one value per gait has it in all rows.

    Args:
        individual: individual of any body.
        place: further columns that tell individuals apart, such as their number in a population.
    """
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
    found |= {name: np.full(rows, value) for name, value in (place or {}).items()}
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
    individuals: Iterable[tuple[Individual, Place]],
) -> tuple[Columns, dict[str, Any]]:
    """Return motions as arrays by channel, each (individuals, …), and their description.

    The description has the frame rate, and the axes, unit and meaning of each channel. The arrays
    `generation`, `member` or those of the places, and `score` are (individuals,); `time`, in
    seconds, is (frames,).

    Args:
        individuals: at least one individual, each with its place as in `motion_columns`.

    Raises:
        GaitsimError: the motions have different shapes.
    """
    found: dict[str, list[Any]] = {}
    about: dict[str, Any] = {}
    frames, rate = 1, 1.0
    for individual, place in individuals:
        one: dict[str, Any] = {"generation": individual.generation}
        if individual.member is not None:
            one["member"] = individual.member.number
        one |= {**place, "score": individual.score}
        channels = individual.experiment.organism.channels
        for name, channel in channels.items():
            one[name] = values = read_values(individual, name)
            check_numbers(individual, name, values)
            if found and (name not in found or found[name][0].shape != values.shape):
                raise GaitsimError(
                    f"the channel {name!r} has another shape in {individual.label}",
                    allowed=".csv and .parquet, which have a row for each frame",
                )
            if not found:
                frames = len(values) if channel.over_time else frames
                names = iter(entries_of(individual, channel, values.shape))
                axes = ["frame" if axis == "frames" else [*next(names)] for axis in channel.axes]
                unit = channel.unit if isinstance(channel.unit, str) else [*channel.unit]
                axes = ["individual", *axes]
                about[name] = {"axes": axes, "unit": unit, "meaning": channel.help}
        rate = individual.motion.frame_rate
        for name, value in one.items():
            found.setdefault(name, []).append(value)
    arrays = {name: np.array(values) for name, values in found.items()}
    arrays["time"] = np.arange(frames) / rate
    return arrays, {"frame_rate": rate, "channels": about}
