"""Import a robot: a URDF or MJCF file becomes the robot's text."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gaitsim_robot import text as robot_text
from gaitsim_robot.child import in_child


@dataclass(frozen=True)
class Imported:
    """A robot that was read from a file.

    Attributes:
        name: of the robot, from the file.
        text: the robot's text.
        repairs: what was dropped, replaced, added or assumed, a line each.
    """

    name: str
    text: str
    repairs: tuple[str, ...]


def import_robot(path: Path, roots: Sequence[Path] = ()) -> Imported:
    """Read a URDF or MJCF file in a child process.

    Args:
        path: the file.
        roots: further folders whose files the robot may use, such as other ROS packages.

    Raises:
        RobotError: it cannot be read, or is not a robot.
    """
    argument = {"path": str(path.absolute()), "roots": [str(root.absolute()) for root in roots]}
    result = in_child("gaitsim_robot.importing.convert:convert", argument, where=str(path))
    robot_text.trust(result["text"])
    return Imported(result["name"], result["text"], tuple(result["repairs"]))
