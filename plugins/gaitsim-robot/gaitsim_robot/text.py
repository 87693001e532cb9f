"""The robot's text: a robot as one normalised MJCF document that needs no other file.

The option `organism.model` contains the text, so that experiment files, checkpoints and champions
include their robot.

- The world has one body, the trunk, with a free joint. Every other joint is a hinge or slide; those
  with a motor have a range.
- Every body has an explicit inertia.
- Geoms are boxes, spheres, capsules, cylinders, ellipsoids, and convex meshes with their vertices
  in the text.
- The largest torque of a joint is its `actuatorfrcrange`. Its `user` values are its largest speed,
  rad/s, and the stiffness, N·m/rad, and damping, N·m·s/rad, of its servo, 0 if unknown. For slides,
  they are in N, m/s, N/m and N·s/m.
- Equality constraints represent mimic joints, closed linkages and couplings by tendons. Tendons are
  fixed. The motor of a tendon moves a joint of the same name, its pulley, which such a coupling
  turns by `gear` times the tendon's length.
- There is at most one keyframe, `stand`.
- The actuators are the motors that the robot's file states, without their properties. If it states
  none, each joint has a motor, and there are actuators only if joints follow others.
- There are no ground, sensors, includes or file names.
"""

from collections.abc import Mapping
from functools import lru_cache
from hashlib import sha256
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

from gaitsim.plugin import unknown
from gaitsim.plugin.toolkit import Servo
from gaitsim_robot.child import run_in_child
from gaitsim_robot.errors import RobotError
from gaitsim_robot.markup import parse


def disable_log() -> None:
    """Keep MuJoCo from printing warnings and from writing them to the working directory.

    gaitsim reports unstable robots as failed individuals, with a reason.
    """
    import mujoco

    config = mujoco.MjLogConfig.get()
    config.logto_console = config.logto_file = False
    mujoco.MjLogConfig.set(config)


LARGEST = 2**20  # characters
BODIES = 500
GEOMS = 2000
VERTICES = 64  # per mesh
WHERE = "the robot's text"

# Kinds of values: a name, one of several words, or numbers (their minimum and maximum count).
_NAME = "name"
_Kind = str | tuple[int, int] | frozenset[str]


def _count(least: int, most: int | None = None) -> tuple[int, int]:
    return least, least if most is None else most


_PLACE: dict[str, _Kind] = {"name": _NAME, "pos": _count(3), "quat": _count(4)}
_ELEMENTS: dict[tuple[str, ...], Mapping[str, _Kind]] = {
    ("mujoco",): {"model": _NAME},
    ("mujoco", "compiler"): {"angle": frozenset({"radian"}), "autolimits": frozenset({"true"})},
    ("mujoco", "asset"): {},
    ("mujoco", "asset", "mesh"): {"name": _NAME, "vertex": _count(12, 3 * VERTICES)},
    ("mujoco", "worldbody"): {},
    ("mujoco", "contact"): {},
    ("mujoco", "contact", "exclude"): {"name": _NAME, "body1": _NAME, "body2": _NAME},
    ("mujoco", "equality"): {},
    ("mujoco", "equality", "joint"): {
        "name": _NAME, "joint1": _NAME, "joint2": _NAME, "polycoef": _count(5),
    },
    ("mujoco", "equality", "connect"): {"name": _NAME, "site1": _NAME, "site2": _NAME},
    ("mujoco", "equality", "weld"): {"name": _NAME, "site1": _NAME, "site2": _NAME},
    ("mujoco", "equality", "tendon"): {"name": _NAME, "tendon1": _NAME},
    ("mujoco", "tendon"): {},
    ("mujoco", "tendon", "fixed"): {
        "name": _NAME, "stiffness": _count(1), "damping": _count(1), "frictionloss": _count(1),
        "springlength": _count(2), "range": _count(2),
    },
    ("mujoco", "tendon", "fixed", "joint"): {"joint": _NAME, "coef": _count(1)},
    ("mujoco", "actuator"): {},
    ("mujoco", "actuator", "motor"): {"joint": _NAME, "tendon": _NAME, "gear": _count(1)},
    ("mujoco", "keyframe"): {},
    ("mujoco", "keyframe", "key"): {"name": frozenset({"stand"}), "qpos": _count(8, 2000)},
    ("body",): _PLACE,
    ("body", "freejoint"): {"name": _NAME},
    ("body", "inertial"): {
        "pos": _count(3), "quat": _count(4), "mass": _count(1), "diaginertia": _count(3),
        "fullinertia": _count(6),
    },
    ("body", "joint"): {
        "name": _NAME, "type": frozenset({"hinge", "slide"}), "pos": _count(3), "axis": _count(3),
        "range": _count(2), "actuatorfrcrange": _count(2), "user": _count(1, 3),
        "damping": _count(1), "armature": _count(1), "frictionloss": _count(1),
        "stiffness": _count(1), "ref": _count(1), "springref": _count(1),
    },
    ("body", "geom"): _PLACE | {
        "type": frozenset({"box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"}),
        "size": _count(1, 3), "fromto": _count(6), "mesh": _NAME, "contype": _count(1),
        "conaffinity": _count(1), "condim": _count(1), "friction": _count(1, 3),
    },
    ("body", "site"): _PLACE,
}  # fmt: skip


def check_text(text: str) -> None:
    """Check that a text is a valid robot's text, before MuJoCo reads it."""
    if len(text) > LARGEST:
        raise RobotError(
            f"the robot's text is too long: {len(text):,} characters",
            where=WHERE,
            allowed=f"at most {LARGEST:,} characters",
        )
    # MuJoCo always reads UTF-8, whatever the XML declaration says, so the check must, too.
    root = parse(text.encode(errors="replace"), WHERE, encoding="utf-8")
    bodies = _check(root)
    trunks = root.findall("worldbody/body")
    if len(trunks) != 1 or len(bodies) > BODIES:
        raise _invalid(
            f"the robot's text has {len(trunks)} trunks and {len(bodies)} bodies",
            f"one trunk, with at most {BODIES} bodies",
        )
    joints = {one.get("name") for one in root.iter("joint")}
    motors = {motor.get("joint") or motor.get("tendon") for motor in root.iter("motor")}
    kinds = [set(motor.keys()) for motor in root.iter("motor")]
    if not motors <= joints or any(one not in ({"joint"}, {"tendon", "gear"}) for one in kinds):
        raise _invalid("invalid motors", "a joint; or a tendon with gear, and a joint of its name")
    for body in bodies:
        _check_body(body, body is trunks[0], motors)
    for tag, most in (("geom", GEOMS), ("mesh", GEOMS), ("joint", BODIES), ("motor", BODIES)):
        if (count := sum(1 for _ in root.iter(tag))) > most:
            raise _invalid(f"the robot's text has {count} elements <{tag}>", f"at most {most}")
    if len(root.findall("keyframe/key")) > 1:
        raise _invalid("the robot's text has several keyframes", "one keyframe, 'stand'")


def _check(root: Element) -> list[Element]:
    """Check elements and attributes; return the bodies."""
    bodies: list[Element] = []
    pending: list[tuple[Element, tuple[str, ...]]] = [(root, (root.tag,))]
    while pending:
        element, path = pending.pop()
        kinds = _ELEMENTS.get(path)
        if kinds is None:
            raise _invalid(f"the robot's text must not contain {' / '.join(path)[:100]!r}")
        if element.tag == "body":
            bodies.append(element)
        for key, value in element.attrib.items():
            if key not in kinds or not _valid(value, kinds[key]):
                raise _invalid(
                    f"invalid attribute {key[:40]}={value[:60]!r} of {element.tag!r}",
                    ", ".join(kinds),
                )
        for child in element:
            nested = child.tag == "body" and path[-1] in ("worldbody", "body")
            pending.append((child, ("body",) if nested else (*path, child.tag)))
    return bodies


def _valid(value: str, kind: _Kind) -> bool:
    if isinstance(kind, frozenset):
        return value in kind
    if isinstance(kind, str):
        return 0 < len(value) <= 120 and value.isprintable()
    words = value.split()
    try:
        return kind[0] <= len(words) <= kind[1] and all(abs(float(one)) <= 1e6 for one in words)
    except ValueError:
        return False


def _check_body(body: Element, trunk: bool, motors: set[str | None]) -> None:
    name = body.get("name", "")
    inertial, joints = body.findall("inertial"), body.findall("joint")
    if not name or len(inertial) != 1 or float(inertial[0].get("mass", "0")) <= 0:
        raise _invalid(f"body {name!r} has no name or no mass", "a name and one <inertial>")
    if len(body.findall("freejoint")) != trunk or bool(joints) == trunk:
        raise _invalid(
            f"body {name!r} has the wrong joints",
            "a free joint for the trunk, and hinges or slides for all other bodies",
        )
    for joint in joints:
        driven = not motors or joint.get("name") in motors
        if not joint.get("name") or (driven and "range" not in joint.attrib):
            raise _invalid(f"a joint of body {name!r} has no name or no range")
        if min(map(float, joint.get("user", "0").split())) < 0:
            raise _invalid(f"a joint of body {name!r} has a servo with negative values")
        for key in ("range", "actuatorfrcrange"):
            lower, upper = map(float, joint.get(key, "-1 1").split())
            if lower >= upper:
                raise _invalid(f"the {key} {joint.get(key)!r} of a joint is not in ascending order")
    for mesh in body.findall("geom"):
        if (mesh.get("type") == "mesh") != ("mesh" in mesh.attrib):
            raise _invalid(f"a geom of body {name!r} has the wrong mesh")


def _invalid(what: str, allowed: str = "") -> RobotError:
    return RobotError(
        what,
        where=WHERE,
        allowed=allowed,
        remedy="import the robot's file again: set organism.model to its path",
    )


_trusted: set[bytes] = set()


def trust(text: str) -> None:
    """Record that a text is safe to compile in this process."""
    _trusted.add(sha256(text.encode()).digest())


@lru_cache(maxsize=8)
def compile_model(text: str) -> Any:
    """Return the compiled model (`mujoco.MjModel`) of a robot's text, without ground or servos.

    A text that this process did not import is first compiled in a child process.
    """
    check_text(text)
    if sha256(text.encode()).digest() not in _trusted:
        run_in_child("gaitsim_robot.text:compile_text", {"text": text}, where=WHERE)
        trust(text)
    import mujoco

    return mujoco.MjModel.from_xml_string(text)


@lru_cache(maxsize=16)
def with_motors(text: str, names: tuple[str, ...]) -> str:
    """Return a robot's text with motors in these joints alone, or for ('all',) wherever possible.

    Raises:
        RobotError: there is no such joint, or it slides without limits.
    """
    model = compile_model(text)
    root = parse(text.encode(), WHERE, encoding="utf-8")
    found = {one.get("name", ""): one for one in root.iter("joint") if one.get("axis")}
    slides = [name for name, one in found.items() if one.get("type") == "slide"]
    endless = [name for name in slides if not found[name].get("range")]
    if names == ("all",):
        names = tuple(name for name in found if name not in endless)
    for name in names:
        if name not in found:
            joints = [model.joint(index).name for index in range(1, model.njnt)]
            raise unknown("joint", name, joints, key="motors")
        if name in endless:
            what = f"the joint {name!r} slides without limits, and motors need some"
            raise RobotError(what, key="motors", remedy="state its range in the robot's file")
        if "range" not in found[name].attrib:
            found[name].set("range", "-1.5708 1.5708")
    pulling = {one.get("tendon"): one.attrib for one in root.iter("motor")}
    for actuator in root.findall("actuator"):
        root.remove(actuator)
    motors = SubElement(root, "actuator")
    for name in names:
        SubElement(motors, "motor", pulling.get(name, {"joint": name}))
    changed = tostring(root, "unicode")
    check_text(changed)
    trust(changed)
    return changed


def with_servos(text: str, servos: Mapping[str, Servo]) -> str:
    """Return a robot's text in which the joints state the limits and gains of their servos."""
    root = parse(text.encode(), WHERE, encoding="utf-8")
    for joint in root.iter("joint"):
        servo = servos.get(joint.get("name", ""))
        if servo is not None and "axis" in joint.attrib:
            limits = (servo.no_load_speed, servo.stiffness, servo.damping)
            joint.set("actuatorfrcrange", f"{-servo.stall_torque!r} {servo.stall_torque!r}")
            joint.set("user", " ".join(map(repr, limits)))
            joint.set("armature", repr(max(float(joint.get("armature", "0")), servo.armature)))
    return tostring(root, "unicode")


def compile_text(text: str) -> dict[str, Any]:
    """Compile a checked text in a child process, and return an empty dictionary."""
    import mujoco

    try:
        mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        raise _invalid(f"MuJoCo cannot compile it: {' '.join(str(error).split())[:300]}") from None
    return {}
