"""Convert a robot's file into the robot's text, in a child process."""

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from gaitsim_robot.errors import RobotError
from gaitsim_robot.importing.files import RobotFiles, read
from gaitsim_robot.importing.joints import repair_joints
from gaitsim_robot.importing.mjcf import read_mjcf
from gaitsim_robot.importing.solids import repair_masses, repair_origin, repair_shapes, robot_size
from gaitsim_robot.importing.tree import write
from gaitsim_robot.importing.urdf import read_urdf
from gaitsim_robot.markup import mistaken_file, parse
from gaitsim_robot.text import check_text, compile_text
from gaitsim_robot.units import unit_warning

# Other documents by their root elements: description and remedy.
_OTHERS = {
    "sdf": (
        "an SDF file of Gazebo",
        "use the URDF from which it was made, or convert it: pip install sdformat-mjcf, then "
        "sdf2mjcf robot.sdf robot.xml",
    ),
    "package": ("the package.xml of a ROS package", "use the .urdf file of the package"),
    "launch": ("a ROS launch file", "use the .urdf file that it loads"),
    "collada": ("a mesh", "use the .urdf file that refers to it"),
}


def convert(
    path: str, roots: Sequence[str], scale: float = 1.0, mass_scale: float = 1.0
) -> dict[str, Any]:
    """Return the name, text, repairs and warnings of the robot in a file."""
    file = Path(path)
    data = read(file)
    document = parse(data, path)
    if scale == mass_scale == 1 and (text := _own_text(data)):
        return {
            "name": document.get("model", file.stem),
            "text": text,
            "repairs": [],
            "warnings": [],
        }
    files = RobotFiles(file.resolve(), [Path(root) for root in roots])
    if document.tag == "robot":
        robot = read_urdf(document, files, path)
    elif document.tag == "mujoco":
        robot = read_mjcf(document, files, path, scale)
    else:
        tag = document.tag.rpartition("}")[2].rpartition(":")[2][:40]
        other = _OTHERS.get(tag.lower()) or mistaken_file(data)
        kind, remedy = other or (f"a <{tag}>", "convert the file to one of these formats")
        raise RobotError(
            f"not a robot: the document is {kind}",
            where=path,
            allowed="URDF (<robot>) or MJCF (<mujoco>)",
            remedy=remedy,
        )
    robot.name = robot.name or file.stem
    robot.rescale(scale, mass_scale)
    repair_joints(robot)
    repair_shapes(robot)
    repair_origin(robot)
    repair_masses(robot)
    text = write(robot)
    try:
        check_text(text)
        compile_text(text)
    except RobotError as error:
        raise RobotError(
            f"the robot cannot be simulated: {error.what}",
            where=path,
            allowed=error.allowed,
            remedy=unit_warning(robot_size(robot), robot.mass)
            or "check the sizes, masses and names in the file",
        ) from None
    return {
        "name": robot.name,
        "text": text,
        "repairs": _fold(dict.fromkeys(robot.repairs)),
        "warnings": robot.warnings,
    }


def _fold(lines: Iterable[str], most: int = 4) -> list[str]:
    """Replace all lines but the first of those that differ only in names, if there are many."""
    alike = defaultdict(list)
    for line in lines:
        alike[re.sub(r"'[^']*'|\"[^\"]*\"", "…", line)].append(line)
    return [
        line
        for group in alike.values()
        for line in (
            group if len(group) <= most else [f"{group[0]}; and {len(group) - 1} more like this"]
        )
    ]


def _own_text(data: bytes) -> str:
    """Return the content of a file that holds a robot's text, such as of `--model-out`, or ''."""
    try:
        text = data.decode()
        check_text(text)
        compile_text(text)
    except (RobotError, UnicodeDecodeError):
        return ""
    return text
