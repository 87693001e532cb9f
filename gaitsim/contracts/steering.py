"""The contract of a body that a person steers: each key selects a controller."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gaitsim.contracts.motion import Motion

KEYS = ("up", "down", "left", "right", "space")
"""Keys that a command may use."""


@dataclass(frozen=True)
class Command:
    """A command that a person can give to a body.

    Args:
        name: name of the command and of its controller, such as 'hover'.
        key: key that gives the command, one of `KEYS`.
        help: effect of the command on the body, one phrase.

    Raises:
        ValueError: the key is unknown, or the name is empty.
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
    """A body that a person steers, simulated frame by frame.

    Attributes:
        frame_rate: frames per second of simulated time, Hz.
    """

    frame_rate: float

    @abstractmethod
    def advance(self, command: str, frames: int) -> Motion:
        """Simulate the next frames under a command.

        Equal sequences of commands must give bit-identical motions, however they are split into
        calls.

        Args:
            command: name of one of the body's commands.
            frames: number of frames, at least 1.

        Returns:
            The motion of a population of one individual in these frames, without the frame before
            them. `Organism.skeleton` and `Organism.measures` must accept it.

        Raises:
            GaitsimError: the command is unknown, or `frames` is below 1.
        """


@dataclass(frozen=True)
class SteeringPage:
    """A script and its data, with which a web page simulates a steered body without gaitsim.

    The script runs in its own scope and calls
    `gaitsim.registerSteering(function (data) { return { frameRate, commands, advance } })`.
    `advance(command, frames)` simulates that many frames and returns `{ends, centre, facts}` for
    the last frame: `ends` is a `Float64Array` with both ends of each segment, in the order of
    `Skeleton.segments`, metres; `centre` is `[x, y, z]`, metres; `facts` are numbers by name, such
    as an altitude. It may also return `shares`, the weight of each controller in the movement, and
    `failed`, which ends the simulation.

    Args:
        script: text of the script, from the body's package.
        data: argument of the registered function; strings, numbers, booleans, None, lists and
            mappings only.
    """

    script: str
    data: Mapping[str, Any]
