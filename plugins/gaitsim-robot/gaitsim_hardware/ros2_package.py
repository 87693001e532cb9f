"""Gaits with reflexes as ROS 2 packages: a node, controllers, a launch file and a URDF."""

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree.ElementTree import SubElement, fromstring, indent, tostring
from xml.sax.saxutils import escape

from gaitsim.plugin import Exported, GaitsimError, plugin_errors
from gaitsim.plugin.runs import Individual, write_bytes
from gaitsim_hardware.c_code import (
    as_comment,
    c_code,
    controller_of,
    filled,
    make_folder,
    with_rhythm,
)

HARDWARE = "mock_components/GenericSystem"  # mirrors commands, until the user names the robot's own
_TEMPLATES = {
    "package.xml": "package.xml",
    "CMakeLists.txt": "CMakeLists.txt",
    "config/controllers.yaml": "controllers.yaml",
    "launch/gait.launch.py": "gait.launch.py.in",
    "src/gait_node.cpp": "gait_node.cpp",
}


def export_package(individual: Individual, folder: Path) -> Exported:
    """Write a gait with its reflexes as a ROS 2 package to a folder, which has its name."""
    name = package_name(folder)
    individual, notices = with_rhythm(individual)
    organism, entry = individual.body, individual.experiment.entries["organism"]
    controller = controller_of(individual)
    with plugin_errors(entry, "writing its URDF"):
        text = organism.urdf()
    if not text:
        raise GaitsimError(
            f"{entry} has no URDF",
            where="--format ros2-package",
            allowed="a body with the method urdf(), such as a robot without mimic joints and "
            "closed linkages",
            remedy="use --format c, and write the package by hand",
        )
    code = c_code(controller, individual.title)
    joints = ros_names(controller.rhythm.joint_names)
    texts = {
        "NAME": name,
        "RATE": str(round(1 / controller.interval)),
        "SPEED": f"{controller.rhythm.own_speed[0]:.3f}",
        "LEGS_TEXT": ", ".join(map(as_comment, controller.rhythm.names)),
        "TITLE": as_comment(individual.title),
    }
    # Each file has its own quotes.
    own = {
        "package.xml": {"TITLE": escape(texts["TITLE"])},
        "config/controllers.yaml": {
            "JOINTS": "\n".join(f"      - {json.dumps(one)}" for one in joints.values())
        },
        "src/gait_node.cpp": {
            "JOINTS": "\n".join(f"    {json.dumps(one)}," for one in joints.values())
        },
    }
    files = {
        path: filled(f"ros2_package/{template}", {**texts, **own.get(path, {})})
        for path, template in _TEMPLATES.items()
    }
    standing = dict(zip(joints.values(), controller.rhythm.standing.tolist(), strict=True))
    files["urdf/robot.urdf"] = ros_urdf(text, joints, standing)
    files |= {"src/gait.h": code.header, "src/gait.c": code.source}
    make_folder(folder)
    for path in files:
        make_folder((folder / path).parent)
    for path, content in files.items():
        write_bytes(folder / path, content.encode(), follow=False)
    return Exported(
        f"package {name} for ROS 2, with gait_node, controllers and URDF; {code.summary}",
        notices,
    )


def package_name(folder: Path) -> str:
    """Return the name of the package in a folder, which ROS requires to be the same."""
    if not re.fullmatch(r"[a-z](_?[a-z0-9])+", folder.name):
        raise GaitsimError(
            f"invalid name for a ROS 2 package: {folder.name!r}",
            where="--out",
            allowed="small letters, digits and single underscores, from a letter",
        )
    return folder.name


def ros_names(names: Iterable[str]) -> dict[str, str]:
    """Return names of letters, digits and underscores, all different, by the original names."""
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "part"
        plain = plain if plain[0].isalpha() else f"part_{plain}"
        number, unique = 2, plain
        while unique in found.values():
            unique, number = f"{plain}_{number}", number + 1
        found[name] = unique
    return found


def ros_urdf(text: str, joints: Mapping[str, str], standing: Mapping[str, float]) -> str:
    """Return a URDF with names for ROS and a block for ros2_control.

    Args:
        text: URDF of the body.
        joints: names for ROS of the joints that the gait moves, by their own names.
        standing: angles of these joints in the standing pose by their names for ROS, rad.
    """
    robot = fromstring(text)
    links = ros_names([one.get("name", "") for one in robot.iter("link")])
    others = [one.get("name", "") for one in robot.iter("joint")]
    named = ros_names([*joints, *(one for one in others if one not in joints)])
    for element in robot.iter():
        if element.tag == "link":
            element.set("name", links[element.get("name", "")])
        elif element.tag == "joint":
            element.set("name", named[element.get("name", "")])
        elif element.tag in ("parent", "child"):
            element.set("link", links[element.get("link", "")])
    control = SubElement(robot, "ros2_control", name="robot", type="system")
    SubElement(SubElement(control, "hardware"), "plugin").text = HARDWARE
    for name, angle in standing.items():
        joint = SubElement(control, "joint", name=name)
        SubElement(joint, "command_interface", name="position")
        state = SubElement(joint, "state_interface", name="position")
        SubElement(state, "param", name="initial_value").text = f"{angle:.9g}"
    indent(robot)
    return f'<?xml version="1.0"?>\n{tostring(robot, encoding="unicode")}\n'
