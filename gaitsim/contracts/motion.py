"""What a body did: named channels over time, measures of it, and a skeleton to draw."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Motion(Mapping[str, Array]):
    """The movement of a whole population, as named channels.

    A channel is an array whose first axis is the population and whose second,
    where it has one, is time. Channels that are costly and not always wanted
    can be given as a function: it is called when one of them is first read,
    and what it returns is kept.

    Args:
        frame_rate: frames a second, Hz.
        channels: arrays by name, each (population, …).
        derived: functions by the names of the channels that each returns.
        failures: why an individual's motion broke down, such as a simulation that left what
            its step can follow, by the individual's index; such an individual scores −inf.
    """

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
        return self._channels[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._channels, *self._derived]))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    @property
    def population(self) -> int:
        """How many individuals moved."""
        return len(next(iter(self._channels.values())))


@dataclass(frozen=True)
class Measure:
    """One quantity that describes how a body moved, for people.

    Args:
        values: one number an individual, (population,).
        unit: its unit as printed, `''` for a pure number.
        help: what it is, one sentence.
    """

    values: Array
    unit: str
    help: str


@dataclass(frozen=True, eq=False)
class Skeleton:
    """One individual's body as line segments over time, enough to draw it.

    Args:
        segments: both ends of each segment, (frames, segments, 2, 3), metres, in
            the world's frame: x forward, y left, z up.
        names: name of each segment.
        frame_rate: frames a second, Hz.
        contacts: points that may touch the ground, (frames, contacts, 3), metres.
        touching: which of them do, (frames, contacts) bool.
        contact_names: name of each of them, such as a leg's.
        centre: the point whose path is the body's path, such as its centre of mass,
            (frames, 3), metres; None takes the mean of the segments' ends.
        ground: where it is uneven along x and the same for every y: x, ascending, and height of
            its corners, (corners, 2), metres; None for level ground at z = 0.

    Raises:
        ValueError: shapes that do not fit each other.
    """

    segments: NDArray[np.floating[Any]]
    names: tuple[str, ...]
    frame_rate: float
    contacts: NDArray[np.floating[Any]] | None = None
    touching: NDArray[np.bool_] | None = None
    contact_names: tuple[str, ...] = ()
    centre: NDArray[np.floating[Any]] | None = None
    ground: NDArray[np.floating[Any]] | None = None

    def __post_init__(self) -> None:
        frames = len(self.segments)
        if self.segments.shape != (frames, len(self.names), 2, 3):
            raise ValueError(
                f"Skeleton.segments has shape {self.segments.shape}, expected "
                f"(frames, segments, 2, 3) with {len(self.names)} segments named"
            )
        if (self.contacts is None) != (self.touching is None):
            raise ValueError("Skeleton.contacts and Skeleton.touching are given together or not")
        if self.contacts is not None and self.touching is not None:
            feet = self.contacts.shape[1]
            if self.contact_names and len(self.contact_names) != feet:
                raise ValueError(
                    f"Skeleton.contact_names names {len(self.contact_names)} contacts of {feet}"
                )
            if self.contacts.shape != (frames, feet, 3) or self.touching.shape != (frames, feet):
                raise ValueError(
                    f"Skeleton.contacts {self.contacts.shape} and touching {self.touching.shape} "
                    f"must be (frames, contacts, 3) and (frames, contacts), frames = {frames}"
                )
        if self.centre is not None and self.centre.shape != (frames, 3):
            raise ValueError(
                f"Skeleton.centre has shape {self.centre.shape}, expected (frames, 3) = "
                f"({frames}, 3)"
            )
        if self.ground is not None:
            if self.ground.ndim != 2 or self.ground.shape[1] != 2 or not len(self.ground):
                raise ValueError(
                    f"Skeleton.ground has shape {self.ground.shape}, expected (corners, 2)"
                )
            if not (np.isfinite(self.ground).all() and (np.diff(self.ground[:, 0]) > 0).all()):
                raise ValueError("Skeleton.ground must be finite, and its x ascending")

    @property
    def path(self) -> NDArray[np.floating[Any]]:
        """Where the body is in each frame, (frames, 3), metres: its `centre`."""
        return self.segments.mean(axis=(1, 2)) if self.centre is None else self.centre
