"""Channels of a motion, read with care: what there is, of which unit, over which axes."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, PluginError, nearest
from gaitsim.registry import plugin_errors
from gaitsim.runs.replay import Replay

# What there may be in the description of a channel before its first comma or blank.
UNITS = (
    "m", "mm", "m/s", "m/s²", "rad", "rad/s", "rad/s²", "°", "°/s", "Hz", "s", "ms", "kg", "N",
    "Nm", "N m", "N·m", "J", "W", "kg m²/s", "kg·m²/s",
)  # fmt: skip
# The names of the last axis where it is no list of joints or feet.
POSE = ("x", "y", "yaw")
SPACE = ("x", "y", "z")
# What descriptions call the axis of the feet, and that of motions from several starts.
FEET = ("legs", "feet", "contacts")
TRIALS = "trials"


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of one individual over time.

    Attributes:
        name: of the channel.
        values: (frames, …).
        axes: names along each axis but time.
        unit: as it is written, '' where it is none or there are several.
        description: what it is.
        rate: frames a second, Hz.
    """

    name: str
    values: NDArray[Any]
    axes: tuple[tuple[str, ...], ...]
    unit: str
    description: str
    rate: float

    def unit_of(self, component: str) -> str:
        """The unit of a component, where they differ."""
        if self.unit or self.name != "pose":
            return self.unit
        return "rad" if component == "yaw" else "m"


def has_channel(replay: Replay, name: str) -> bool:
    """Whether the body has a channel."""
    return name in replay.experiment.organism.channels


def read_values(replay: Replay, name: str) -> NDArray[Any]:
    """A channel of the individual, without the axis of the population.

    Raises:
        GaitsimError: the body has no such channel; all it has are listed.
        PluginError: the body cannot work it out.
    """
    entry, organism = replay.experiment.entries["organism"], replay.experiment.organism
    if name not in organism.channels:
        raise GaitsimError(
            f"{entry} has no channel {name!r}",
            where=str(replay.run.path),
            allowed="".join(f"\n    {one}: {what}" for one, what in organism.channels.items()),
            remedy=nearest(name, [*organism.channels]),
        )
    with plugin_errors(entry, f"working out the channel {name!r}"):
        values = np.asarray(replay.motion[name])
    if values.ndim == 0 or len(values) != 1:
        raise PluginError(
            f"{entry} gave the channel {name!r} with the shape {values.shape} for one individual",
            where=entry.target,
            allowed="(1, …): the first axis is the population",
        )
    one: NDArray[Any] = values[0]
    return one


def trials_of(replay: Replay) -> int:
    """From how many starts the individual moved: an axis of its channels; a skeleton shows one."""
    for name, description in replay.experiment.organism.channels.items():
        tokens, _ = _parsed(description)
        if TRIALS in tokens[1:]:
            shape = read_values(replay, name).shape
            if len(shape) + 1 == len(tokens):
                return int(shape[tokens.index(TRIALS) - 1])
    return 1


def over_time(replay: Replay, name: str) -> bool:
    """Whether a channel that the body has goes over time."""
    values = read_values(replay, name)
    tokens, _ = _parsed(replay.experiment.organism.channels[name])
    if values.ndim == 0 or len(values) < 2:
        return False
    return tokens[1:2] == ["frames"] or len(values) == len(replay.skeleton.segments)


def read_channel(replay: Replay, name: str) -> Channel:
    """A channel of the individual over time, its axes named.

    Raises:
        GaitsimError: the body has no such channel, or it does not go over time.
        PluginError: the body cannot work it out, or its values are no numbers.
    """
    organism, entry = replay.experiment.organism, replay.experiment.entries["organism"]
    values = read_values(replay, name)
    if values.dtype.kind not in "biuf":
        raise PluginError(
            f"{entry} gave the channel {name!r} as {values.dtype}",
            where=entry.target,
            allowed="real numbers or truth values",
        )
    if not over_time(replay, name):
        timed = [one for one in organism.channels if over_time(replay, one)]
        raise GaitsimError(
            f"the channel {name!r} of {entry} is one value a gait, not one a frame",
            allowed=", ".join(timed) or "no channel of this body goes over time",
        )
    tokens, words = _parsed(organism.channels[name])
    with plugin_errors(entry, "naming its joints"):
        joints = tuple(str(joint) for joint in organism.joint_names())
    feet = replay.skeleton.contact_names
    fitting = [unit for unit in UNITS if re.match(rf"{re.escape(unit)}(?:[,;:. ]|$)", words)]
    unit = max(fitting, key=len, default="")  # 'N m' begins as 'N' does
    said = words.removeprefix(unit).lstrip(",;:. ")
    axes: list[tuple[str, ...]] = []
    for index, length in enumerate(values.shape[1:]):
        token = tokens[index + 2] if len(tokens) == values.ndim + 1 else ""
        last = index == values.ndim - 2
        names = _names(name, length, token, last, said, joints, feet)
        feet = () if names == feet else feet  # they are along one axis
        axes.append(names)
    return Channel(
        name=name,
        values=values,
        axes=tuple(axes),
        unit=unit,
        description=said,
        rate=replay.motion.frame_rate,
    )


def _names(
    channel: str,
    length: int,
    token: str,
    last: bool,
    words: str,
    joints: Sequence[str],
    feet: Sequence[str],
) -> tuple[str, ...]:
    """Names along one axis of a channel: what its word says, else what its length may be."""
    if len(joints) == length and (channel == "joint_angles" or token == "joints"):
        return tuple(joints)
    if token.isalpha():
        if length == len(feet) and token in FEET:
            return tuple(feet)
        if last and token != TRIALS and (listed := _listed(words, length)):
            return listed
        # An axis called 'trials' has the entries 'trial 0', 'trial 1' …
        return tuple(f"{token.removesuffix('s')} {entry}" for entry in range(length))
    if last and channel == "pose" and length == len(POSE):
        return POSE
    if last and (listed := _listed(words, length)):
        return listed
    if length == len(feet) and re.search(r"\b(?:legs?|feet|foot|contacts?)\b", words):
        return tuple(feet)
    if last and length == len(SPACE):
        return SPACE
    return tuple(str(entry) for entry in range(length))


def _listed(words: str, length: int) -> tuple[str, ...]:
    """Names that a description lists, or ().

    As 'w, x, y, z', 'x and z' or 'flap, pitch; left, then right'.
    """
    for found in re.findall(r"\w+(?:, \w+)+|\b[xyz] and [xyz]\b", words):
        names = tuple(re.split(", | and ", found))
        if len(names) == length:
            return names
        if 2 * len(names) == length and "left, then right" in words:
            return tuple(f"{side} {name}" for side in ("left", "right") for name in names)
    return ()


def _parsed(description: str) -> tuple[list[str], str]:
    """The shape that a description begins with, as words, and what follows it."""
    found = re.match(r"\s*\(([^()]*)\)\s*", description)
    if not found:
        return [], description.strip()
    tokens = [token.strip() for token in found[1].split(",")]
    return [token for token in tokens if token], description[found.end() :].strip()
