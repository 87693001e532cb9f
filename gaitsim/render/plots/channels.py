"""The channels of one individual's motion as signals over time."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError
from gaitsim.gait.channels import channels_of, entries_of, read_values
from gaitsim.individual import Individual


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
