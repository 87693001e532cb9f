"""The contract of a body under a person's command: keys choose which controller steers it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gaitsim.contracts.motion import Motion

KEYS = ("up", "down", "left", "right", "space")
"""Keys that a command may have."""


@dataclass(frozen=True)
class Command:
    """One thing that a person can tell a body to do.

    Args:
        name: of the command and of its controller, such as 'hover'.
        key: one of `KEYS`.
        help: what the body then does, one phrase.

    Raises:
        ValueError: another key, or no name.
    """

    name: str
    key: str
    help: str

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("Command.name is empty")
        if self.key not in KEYS:
            raise ValueError(f"Command.key is {self.key!r}, expected one of {', '.join(KEYS)}")


class Steered(ABC):
    """A body under a person's command, simulated frame by frame.

    Attributes:
        frame_rate: frames a second of simulated time, Hz.
    """

    frame_rate: float

    @abstractmethod
    def advance(self, command: str, frames: int) -> Motion:
        """Simulate the next frames under a command.

        Equal sequences of commands give equal bits, however they are cut into calls.

        Args:
            command: name of one of the body's commands.
            frames: number of frames, at least 1.

        Returns:
            The motion of a population of one in these frames, without the state before them;
            `Organism.skeleton` and `Organism.measures` work on it.

        Raises:
            GaitsimError: an unknown command, or fewer than one frame.
        """


@dataclass(frozen=True)
class SteeringPage:
    """What a web page needs to simulate a body under a person's command by itself.

    The script, which runs in a scope of its own, evaluates to
    `gaitsim.registerSteering(function (data) { return { frameRate, commands, advance } })`, where
    `advance(command, frames)` returns `{ends, centre, facts}` of the last of these frames: `ends`
    is a `Float64Array` of both ends of each segment, in the order of `Skeleton.segments`, metres;
    `centre` is `[x, y, z]`, metres; `facts` are numbers by name, such as an altitude. It may return
    `shares`, too, how much each controller has of the command, and `failed`, which ends the flight.

    Args:
        script: text of the script, which comes from the body's package.
        data: what is passed to its function; of texts, numbers, truth values, None, lists and
            mappings alone.
    """

    script: str
    data: Mapping[str, Any]
