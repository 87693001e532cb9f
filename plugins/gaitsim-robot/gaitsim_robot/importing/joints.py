"""Repair the joints of a robot: free the trunk, fix motors of other kinds, and set limits."""

import math
from dataclasses import replace

import numpy as np

from gaitsim_robot.errors import RobotError, check_count, format_names
from gaitsim_robot.importing.tree import Body, Floats, RobotTree, TreeJoint, report
from gaitsim_robot.markup import LARGEST
from gaitsim_robot.text import BODIES

ASSUMED = math.pi / 2  # rad, limit assumed for a joint without limits
TURN = 2 * math.pi  # rad; a joint with a larger limit turns freely
DEGREES = 25.0  # rad; larger limits look like degrees, as files without limits state ±10 or ±3π


def repair_joints(robot: RobotTree) -> None:
    """Free the trunk, leave hinges and slides, fuse fixed bodies, and limit hinges.

    Bodies keep their positions in the initial pose, in which all joints are at zero.
    """
    root = robot.root
    if any(joint.kind != "free" for joint in root.joints):
        names = [joint.name for joint in root.joints]
        report(robot.repairs, "joints between the world and the robot, now free", names)
    root.joints = []
    if not robot.motors_stated:
        _assume_motors(robot)
    _replace_joints(robot)
    _fuse(robot)
    _merge_massless(robot)
    check_count(sum(1 for _ in root.walk()), BODIES, "moving links", robot.name)
    if not any(joint.driven for joint in robot.joints):
        raise RobotError(
            "the robot has no joint that a motor moves",
            where=robot.name,
            allowed="at least one hinge or slide with limits; if the file has actuators or "
            "transmissions, they must drive it",
        )
    _warn_of_degrees(robot)
    _assume_limits(robot)
    _filter_couplings(robot)
    passive = [joint.name for joint in robot.joints if not joint.driven]
    report(robot.repairs, "passive joints, for which the file states no motor", passive)


def _assume_motors(robot: RobotTree) -> None:
    """Leave motors only at the beginning of both branches of a closed linkage."""
    carrier = {site: body for body in robot.root.walk() for site in body.sites}
    parent = {child: body for body in robot.root.walk() for child in body.children}

    def path(site: str) -> list[Body]:
        found = [carrier[site]]
        while found[0] in parent:
            found.insert(0, parent[found[0]])
        return found

    first: list[str] = []
    for closure in robot.closures:
        ends = path(closure.first), path(closure.second)
        for bodies, others in (ends, ends[::-1]):
            branch = [joint for body in bodies if body not in others for joint in body.joints]
            first += [joint.name for joint in branch[:1] if joint.name not in first]
            for joint in branch[1:]:
                joint.driven = False
    if first:
        robot.warnings.append(
            "the file states no motors: of the joints in closed linkages, only those next to the "
            f"trunk are assumed to have one, {format_names(first)}; 'organism.motors' names others"
        )


def _replace_joints(robot: RobotTree) -> None:
    """Replace passive balls by three hinges, and fix other joints than hinges and slides.

    Slides with a motor need limits.

    The axes of the three hinges are orthogonal, and their inertia, springs and damping about each
    axis are those of the ball as long as it turns little.
    """
    driven: list[str] = []
    others: list[str] = []
    balls: list[str] = []
    for body in robot.root.walk():
        kept: list[TreeJoint] = []
        for joint in body.joints:
            limited = joint.range is not None and np.abs(joint.range).max() <= LARGEST
            if joint.kind == "hinge" or (joint.kind == "slide" and (limited or not joint.driven)):
                kept.append(joint)
            elif joint.kind == "ball" and not joint.driven:
                balls.append(joint.name)
                kept += [
                    replace(joint, kind="hinge", name=f"{joint.name} {letter}", axis=axis,
                            position=joint.position.copy(), range=None)
                    for letter, axis in zip("xyz", np.eye(3), strict=True)
                ]  # fmt: skip
            else:
                (driven if joint.driven else others).append(joint.name)
        body.joints = kept
    report(robot.repairs, "passive ball joints, now three passive hinges each", balls)
    report(robot.repairs, "joints fixed, because they are neither hinges nor slides", others)
    if driven:
        robot.warnings.append(
            f"joints with a motor that gaitsim cannot drive are fixed at 0: "
            f"{format_names(driven)}; state the limits of slides, drive three hinges in place of a "
            "ball, or remove the motors from the file's actuators or transmissions to leave these "
            "joints passive"
        )


def _fuse(robot: RobotTree) -> None:
    """Fuse bodies without joints into their parents."""
    fused = 0
    for body in reversed(list(robot.root.walk())):
        kept: list[Body] = []
        for child in body.children:
            if child.joints:
                kept.append(child)
                continue
            fused += 1
            for grandchild in child.children:
                grandchild.place = child.place @ grandchild.place
            kept += child.children
            nothing = not (body.mass or body.shapes or body.incomplete)
            if nothing and (child.mass or child.incomplete):  # `world` or `base_footprint`
                _rename(robot, body.name, child.name)
                body.name, body.incomplete = child.name, child.incomplete
            else:
                _rename(robot, child.name, body.name)
            _merge(body, child)
        body.children = kept
    if fused:
        robot.repairs.append(f"fixed links merged into their parents: {fused}")


def _rename(robot: RobotTree, old: str, new: str) -> None:
    pairs = [tuple(new if name == old else name for name in pair) for pair in robot.excludes]
    robot.excludes = [(first, second) for first, second in pairs if first != second]


def _merge(body: Body, part: Body) -> None:
    """Add the mass, shapes and sites of a part that is fixed to the body."""
    inner = part.place
    for shape in part.shapes:
        shape.place = inner @ shape.place
    body.shapes += part.shapes
    body.lost |= part.lost
    body.sites |= {name: inner @ place for name, place in part.sites.items()}
    centre = inner.point(part.centre)
    inertia = inner.rotation @ part.inertia @ inner.rotation.T
    mass = body.mass + part.mass
    if mass > 0:
        mean = (body.mass * body.centre + part.mass * centre) / mass
        body.inertia = (
            body.inertia
            + _parallel_axis(body.mass, body.centre - mean)
            + inertia
            + _parallel_axis(part.mass, centre - mean)
        )
        body.mass, body.centre = mass, mean


def _parallel_axis(mass: float, offset: Floats) -> Floats:
    """Return the inertia of a mass at an offset (parallel axis theorem), (3, 3)."""
    return mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))


def _merge_massless(robot: RobotTree) -> None:
    """Merge a body without mass or shape with its only child into one body with both joints.

    Files often describe universal joints like this. The merged body moves in the same way.
    """
    for body in robot.root.walk():
        while (
            body is not robot.root
            and not (body.mass or body.shapes or body.sites)
            and len(body.children) == 1
        ):
            child = body.children[0]
            back = child.place.inverse()
            for joint in body.joints:
                joint.position = back.point(joint.position)
                joint.axis = back.rotation @ joint.axis
            body.place = body.place @ child.place
            _rename(robot, body.name, child.name)
            body.name, body.joints = child.name, body.joints + child.joints
            body.mass, body.centre, body.inertia = child.mass, child.centre, child.inertia
            body.shapes, body.sites, body.children = child.shapes, child.sites, child.children


def _warn_of_degrees(robot: RobotTree) -> None:
    """Warn if most limits look like degrees: several turns if read as radians, but at most 360°."""
    hinges = [joint for joint in robot.joints if joint.kind == "hinge"]
    given = [(joint.name, joint.range) for joint in hinges if joint.range is not None]
    ranges = [(name, ends) for name, ends in given if np.isfinite(ends).all()]
    suspicious = [one for one in ranges if DEGREES <= max(map(abs, one[1])) <= 360]
    if suspicious and 2 * len(suspicious) >= len(ranges):
        name, (low, high) = suspicious[0]
        robot.warnings.append(
            f"the limits of {len(suspicious)} of {len(ranges)} joints are probably degrees, as "
            f"radians would be several turns, such as {low:.4g} to {high:.4g} of {name!r}; write "
            f"them in radians: {math.radians(low):.4g} to {math.radians(high):.4g}"
        )


def _assume_limits(robot: RobotTree) -> None:
    endless: list[str] = []
    missing: list[str] = []
    for joint in robot.joints:
        if joint.torque > LARGEST:  # in files, a huge value means no limit
            joint.torque = 0.0
        if joint.speed > LARGEST:
            joint.speed = 0.0
        joint.servo_stiffness = min(joint.servo_stiffness, LARGEST)
        joint.servo_damping = min(joint.servo_damping, LARGEST)
        if not joint.driven:
            if joint.range is not None and not np.isfinite(joint.range).all():
                joint.range = None
        elif joint.range is None:
            missing.append(joint.name)
            joint.range = (joint.reference - ASSUMED, joint.reference + ASSUMED)
        elif joint.kind == "hinge" and not all(abs(limit) <= TURN for limit in joint.range):
            endless.append(joint.name)
            low, high = joint.range
            turn = joint.reference - math.pi, joint.reference + math.pi
            low = low if abs(low) <= TURN else turn[0]
            high = high if abs(high) <= TURN else turn[1]
            joint.range = (low, high) if low < high else turn
    report(robot.repairs, "joints without limits, ±90° assumed", missing)
    report(robot.repairs, "joints that turn endlessly, limited to ±180°", endless)


def _filter_couplings(robot: RobotTree) -> None:
    """Keep only the couplings and tendons between existing joints."""
    joints = {joint.name for joint in robot.joints}
    couplings = [one for one in robot.couplings if one.follower != one.leader]
    couplings = [one for one in couplings if {one.follower, one.leader} <= joints]
    if dropped := len(robot.couplings) - len(couplings):
        robot.repairs.append(f"dropped couplings to fixed or missing joints: {dropped}")
    robot.couplings = couplings
    lost = [one.name for one in robot.tendons if not {name for name, _ in one.joints} <= joints]
    report(robot.repairs, "dropped tendons of fixed joints", lost)
    robot.tendons = [one for one in robot.tendons if one.name not in lost]
