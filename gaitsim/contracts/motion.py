"""The motion of a body: its channels, its measures, and the skeleton to draw."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts.conditions import Terrain
from gaitsim.contracts.rig import SkeletonError, Solid
from gaitsim.errors import nearest
from gaitsim.repr_mixin import ReprField, ReprMixin, TableMixin

Array = NDArray[Any]


@dataclass(frozen=True)
class Channel:
    """A declared channel of a motion.

    `Channel(("frames", "feet", ("x", "y", "z")), "m", "in the world")` declares an array of shape
    (population, frames, feet, 3). Some axis names have a meaning: `frames` is time; `joints` has
    an entry for each name in the body's `joint_names()`, `feet` for each of its skeleton's
    `contact_names`, and `trials` for each starting position of the same individual.

    Args:
        axes: axes after the population axis. Each is the name of an axis whose length depends on
            the body and its options, or a tuple that names the entries of an axis of fixed length.
        unit: unit as printed; `''` for a pure number or a boolean. If the entries of the last axis
            have different units, a tuple with the unit of each entry.
        help: description of the channel, one phrase.

    Raises:
        ValueError: `axes` is not a tuple, `frames` is not its first entry, or the units do not
            match the last axis.
    """

    axes: tuple[str | tuple[str, ...], ...]
    unit: str | tuple[str, ...]
    help: str

    def __post_init__(self) -> None:
        if not isinstance(self.axes, tuple) or "frames" in self.axes[1:]:
            raise ValueError(
                f"Channel.axes is {self.axes!r}, expected a tuple; 'frames' must come first"
            )
        if isinstance(self.unit, tuple):
            last = self.axes[-1] if self.axes else ()
            if isinstance(last, str) or len(last) != len(self.unit):
                raise ValueError(
                    f"Channel.unit is {self.unit!r}, expected a string, or a string for each named "
                    f"entry of the last axis, which is {last!r}"
                )

    @property
    def over_time(self) -> bool:
        """Whether the first axis after the population is time."""
        return self.axes[:1] == ("frames",)

    def unit_of(self, entry: int) -> str:
        """Return the unit of an entry of the last axis."""
        return self.unit if isinstance(self.unit, str) else self.unit[entry]

    def fits(self, shape: tuple[int, ...]) -> bool:
        """Return whether an array with `shape` matches the axes of the channel.

        Args:
            shape: shape of the array, whose first axis is the population.
        """
        return len(shape) == len(self.axes) + 1 and all(
            isinstance(axis, str) or len(axis) == length
            for axis, length in zip(self.axes, shape[1:], strict=True)
        )

    @property
    def shape(self) -> str:
        """The shape as a string, such as '(population, frames, [x, y, yaw])'."""
        names = ("population", *map(_joined, self.axes))
        return f"({', '.join(names)})" if self.axes else "(population,)"

    @property
    def units(self) -> str:
        """The units as a string, such as '[m, m, rad]'."""
        return _joined(self.unit)

    def __str__(self) -> str:
        return f"{self.shape} {self.units}".rstrip() + f": {self.help}"


def _joined(names: str | tuple[str, ...]) -> str:
    return names if isinstance(names, str) else f"[{', '.join(names)}]"


PRESENT = "present"
PRESENT_CHANNEL = Channel(("joints",), "", "whether the individual has the joint")
"""Channel of a body whose individuals differ in their joints.

In motions of populations, arrays over joints have room for the largest body: the joints of an
individual come first, in the order of the `joint_names` of its own body (`Organism.embody`), and
the rest is 0. Arrays over feet are padded likewise. Padding must not change terms and measures.
"""


class Motion(TableMixin, Mapping[str, Array]):
    """The movement of a whole population, as named channels.

    A channel is an array whose first axis is the population; `Organism.channels` declares its
    other axes. Channels that are expensive to compute can be given as a function. It is called
    once, when one of the channels that it returns is first read.

    Args:
        frame_rate: frames per second, Hz.
        channels: arrays by name, each of shape (population, …).
        derived: functions that compute channels; each key holds the names of the channels that
            its function returns.
        failures: reason why a motion failed, such as an unstable simulation, by index of the
            individual. The score of a failed individual is −inf.

    Attributes:
        declared: declarations of the channels by name, with units and axes; {} if unknown.

    Raises:
        KeyError: a channel does not exist; the message names the existing ones.
    """

    declared: Mapping[str, Channel] = MappingProxyType({})

    def __init__(
        self,
        frame_rate: float,
        channels: Mapping[str, Array],
        derived: Mapping[tuple[str, ...], Callable[[], Mapping[str, Array]]] | None = None,
        failures: Mapping[int, str] | None = None,
    ) -> None:
        self.frame_rate = frame_rate
        self.failures = dict(failures or {})
        self._channels = dict(channels)
        self._derived = {
            name: function for names, function in (derived or {}).items() for name in names
        }

    def __getitem__(self, name: str) -> Array:
        if name not in self._channels and name in self._derived:
            self._channels.update(self._derived[name]())
        if name not in self._channels:
            close = nearest(str(name), [*self], 0.5)
            known = f"channels: {', '.join(map(str, self))}"
            raise KeyError(f"no channel {name!r}; {f'{close} ' if close else ''}{known}")
        return self._channels[name]

    def __contains__(self, name: object) -> bool:
        return name in self._channels or name in self._derived

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._channels, *self._derived]))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def add(self, name: str, values: Array) -> None:
        """Add a channel, (population, …)."""
        self._channels[name] = values

    @property
    def population(self) -> int:
        """The number of individuals."""
        known = self._channels or {name: self[name] for name in [*self._derived][:1]}
        return len(next(iter(known.values()), ()))

    def of(self, index: int) -> "Motion":
        """Return the motion of one individual, a population of one."""
        one = slice(index, index + 1)
        failures = {0: self.failures[index]} if index in self.failures else {}
        known = {name: values[one] for name, values in self._channels.items()}
        derived: dict[tuple[str, ...], Callable[[], Mapping[str, Array]]] = {
            (name,): partial(self._channel_of, name, one) for name in self._derived
        }
        found = Motion(self.frame_rate, known, derived, failures)
        found.declared = self.declared
        return found

    def _channel_of(self, name: str, part: slice) -> Mapping[str, Array]:
        return {name: self[name][part]}

    def _repr_title(self) -> str:
        return f"Motion of {self.population} at {self.frame_rate:g} Hz"

    def _repr_rows(self) -> list[dict[str, object]]:
        # Channels that were not read yet are not computed for their shapes.
        return [
            {
                "channel": name,
                "shape": str(self._channels[name].shape)
                if name in self._channels
                else self.declared[name].shape
                if name in self.declared
                else "",
                "unit": self.declared[name].units if name in self.declared else "",
                "meaning": self.declared[name].help if name in self.declared else "",
            }
            for name in self
        ]


@dataclass(frozen=True, eq=False)
class Measure:
    """A quantity that describes how a body moved; unlike a term, it is not part of the score.

    Args:
        source: value for each individual, an array of shape (population,); or a function that
            returns this array and is called when the values are first read.
        unit: unit as printed; `''` for a pure number.
        help: description of the quantity, one phrase.
    """

    source: Array | Callable[[], Array]
    unit: str
    help: str

    @cached_property
    def values(self) -> Array:
        """The value for each individual, (population,)."""
        return self.source() if callable(self.source) else self.source


@dataclass(frozen=True, eq=False, repr=False)
class Skeleton(ReprMixin):
    """The geometry of one individual over time, for drawing: line segments and optional solids.

    Args:
        segments: both ends of each segment, (frames, segments, 2, 3), metres, in the world frame:
            x forward, y left, z up.
        names: name of each segment.
        frame_rate: frames per second, Hz.
        contacts: points that may touch the ground, (frames, contacts, 3), metres.
        touching: whether each contact touches the ground, (frames, contacts) bool.
        contact_names: name of each contact, such as the name of its leg.
        centre: point whose path is the path of the body, such as its centre of mass, (frames, 3),
            metres; None for the mean of the segments' ends.
        ground: None for level ground at z = 0. For ground that varies along x only, the corners of
            its profile in ascending order of x: x and height of each, (corners, 2), metres. For
            ground that varies in x and y, a `Terrain`.
        solids: rigid solids of the body.
        poses: position, metres, and unit quaternion (w, x, y, z) of each solid in the world frame,
            (frames, solids, 7).
        damaged: names of the segments and solids that damage affects, and of the contacts of lost
            legs.

    Raises:
        SkeletonError: the shapes do not match each other, a name in `damaged` is unknown, or the
            profile of the ground has non-finite values or is not in ascending order of x.
    """

    segments: NDArray[np.floating[Any]]
    names: tuple[str, ...]
    frame_rate: float
    contacts: NDArray[np.floating[Any]] | None = None
    touching: NDArray[np.bool_] | None = None
    contact_names: tuple[str, ...] = ()
    centre: NDArray[np.floating[Any]] | None = None
    ground: NDArray[np.floating[Any]] | Terrain | None = None
    solids: tuple[Solid, ...] = ()
    poses: NDArray[np.floating[Any]] | None = None
    damaged: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if (self.contacts is None) != (self.touching is None):
            raise SkeletonError("Skeleton.contacts and Skeleton.touching must be given together")
        if bool(self.solids) != (self.poses is not None):
            raise SkeletonError("Skeleton.solids and Skeleton.poses must be given together")
        frames = len(self.segments)
        shapes = {"segments": (frames, len(self.names), 2, 3), "centre": (frames, 3)}
        shapes["poses"] = (frames, len(self.solids), 7)
        if self.contacts is not None:
            feet = (len(self.contact_names),) if self.contact_names else self.contacts.shape[1:2]
            shapes |= {"contacts": (frames, *feet, 3), "touching": (frames, *feet)}
        profile = None if isinstance(self.ground, Terrain) else self.ground
        if profile is not None:
            shapes["ground"] = (len(profile), 2)
        for name, expected in shapes.items():
            array = getattr(self, name)
            if isinstance(array, np.ndarray) and array.shape != expected:
                raise SkeletonError(f"Skeleton.{name} has shape {array.shape}, expected {expected}")
        solids = (solid.name for solid in self.solids)
        known = {*self.names, *self.contact_names, *solids}
        if unknown := [*{*self.damaged} - known]:
            raise SkeletonError(f"Skeleton.damaged has {unknown}: not a segment, solid or contact")
        if profile is not None and not (
            len(profile) and np.isfinite(profile).all() and (np.diff(profile[:, 0]) > 0).all()
        ):
            raise SkeletonError("Skeleton.ground must have finite corners in ascending order of x")

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "frames": len(self.segments),
            "frame_rate": self.frame_rate,
            "segments": len(self.names),
            "contacts": 0 if self.contacts is None else self.contacts.shape[1],
            "solids": len(self.solids),
            "damaged": ", ".join(self.damaged),
        }

    @property
    def path(self) -> NDArray[np.floating[Any]]:
        """Position of the body in each frame, (frames, 3), metres; see `centre`."""
        return self.segments.mean(axis=(1, 2)) if self.centre is None else self.centre
