"""The contract of a body that a person steers with keys, each of which gives a command."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gaitsim.choices import STEERING_KEYS
from gaitsim.contracts.motion import Motion


@dataclass(frozen=True)
class Command:
    """A command that a person can give to a body by pressing a key.

    Args:
        name: name of the command, such as 'hover' or 'faster'.
        key: key that gives the command, one of `gaitsim.choices.STEERING_KEYS`.
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
        if self.key not in STEERING_KEYS:
            allowed = ", ".join(STEERING_KEYS)
            raise ValueError(f"Command.key is {self.key!r}, expected one of {allowed}")


class Steered(ABC):
    """A body that a person steers, simulated frame by frame.

    Equal sequences of commands, each given before the same frame, must give bit-identical motions,
    however the frames are split into calls of `advance`.

    Attributes:
        frame_rate: frames per second of simulated time, Hz.
    """

    frame_rate: float

    @abstractmethod
    def give(self, command: str) -> None:
        """Give a command, as one press of its key does; it acts from the next frame.

        Args:
            command: name of one of the body's commands.

        Raises:
            GaitsimError: the command is unknown.
        """

    @abstractmethod
    def advance(self, frames: int) -> Motion:
        """Simulate the next frames.

        Args:
            frames: number of frames, at least 1.

        Returns:
            The motion of a population of one individual in these frames, without the frame before
            them. `Organism.skeleton` and `Organism.measures` must accept it.

        Raises:
            GaitsimError: `frames` is below 1.
        """

    def facts(self) -> Mapping[str, str]:
        """Return what the body is asked to do, for display: values with units by name.

        For example, `{"asked speed": "0.20 m/s"}`. Names of up to 11 characters, numbers of up to 8
        and units of up to 7 fit beside the body in a terminal of 80 columns.
        """
        return {}

    def notice(self) -> str:
        """Return what the person should know now, a sentence, or ''.

        For example, that the gait cannot follow the commands and clips them.
        """
        return ""

    def drive(self) -> Mapping[str, Any]:
        """Return the options of the body that make `Organism.move` repeat this drive bit for bit.

        For example, `{"drive": [...], "duration": 12.5}`. They are valid from the start on, and a
        body with them draws the drive. The genome to move is that of the body's only controller.
        The default {} means that drives cannot be recorded.
        """
        return {}
