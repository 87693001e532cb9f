"""Import robots: convert a URDF or MJCF file into the robot's text."""

from collections.abc import Sequence
from pathlib import Path

from gaitsim.plugin import BodyFile
from gaitsim_robot import text as robot_text
from gaitsim_robot.child import run_in_child


def import_robot(
    path: Path, roots: Sequence[Path] = (), *, scale: float = 1.0, mass_scale: float = 1.0
) -> BodyFile:
    """Read the robot in a URDF or MJCF file, in a child process.

    Args:
        path: the file.
        roots: additional folders with files that the robot may use, such as other ROS packages.
        scale: factor of all lengths.
        mass_scale: factor of all masses.
    """
    argument = {
        "path": str(path.absolute()),
        "roots": [str(root.absolute()) for root in roots],
        "scale": scale,
        "mass_scale": mass_scale,
    }
    result = run_in_child("gaitsim_robot.importing.convert:convert", argument, where=str(path))
    robot_text.trust(result["text"])
    return BodyFile(
        result["name"], result["text"], tuple(result["repairs"]), tuple(result["warnings"])
    )
