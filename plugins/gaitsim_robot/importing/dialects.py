"""Convert MJCF of older versions and other programs into the form that MuJoCo reads now."""

from xml.etree.ElementTree import Element

import numpy as np

from gaitsim_robot.importing.tree import Floats
from gaitsim_robot.markup import numbers

_TURNED = frozenset({"quat", "euler", "axisangle", "xyaxes", "zaxis"})


def modernise(root: Element, where: str, repairs: list[str]) -> None:
    """Convert a document in place.

    Bullet's examples have inertias without a position and joints of type `fixed`. MuJoCo before
    2.3.4 had global coordinates and an option `collision`.
    """
    for option in root.iter("option"):
        for old in ("collision", "apirate"):
            option.attrib.pop(old, None)
    for inertial in root.iter("inertial"):
        inertial.set("pos", inertial.get("pos", "0 0 0"))
    for body in root.iter("body"):
        body[:] = [one for one in body if one.tag != "joint" or one.get("type") != "fixed"]
    compilers = [one for one in root.iter("compiler") if one.get("coordinate") == "global"]
    bodies = list(root.iter("body"))
    if compilers and not any(_TURNED & set(body.attrib) for body in bodies):
        for compiler in compilers:
            del compiler.attrib["coordinate"]
        for world in root.iter("worldbody"):
            for body in world.iterfind("body"):
                _localise(body, np.zeros(3), where)
        repairs.append("converted global coordinates")


def _localise(body: Element, outer: Floats, where: str) -> None:
    """Convert the positions within a body from the world's frame to the body's."""
    origin = numbers(body.get("pos"), 3, " ".join(map(str, outer)), where)
    body.set("pos", _words(origin - outer))
    for child in body:
        if child.tag == "body":
            _localise(child, origin, where)
            continue
        if "pos" in child.attrib:
            child.set("pos", _words(numbers(child.get("pos"), 3, "", where) - origin))
        if "fromto" in child.attrib:
            ends = numbers(child.get("fromto"), 6, "", where)
            child.set("fromto", _words(ends - np.tile(origin, 2)))


def _words(values: Floats) -> str:
    return " ".join(f"{value:.10g}" for value in values)
