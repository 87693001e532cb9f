"""Repair the bodies of a robot: few convex shapes, a mass and a physically possible inertia."""

import math

import numpy as np
from scipy.spatial import ConvexHull

from gaitsim_robot.errors import RobotError, check_count
from gaitsim_robot.importing.meshes import VERTICES, box, check_vertices, hull
from gaitsim_robot.importing.tree import Body, Floats, Place, RobotTree, Shape, report
from gaitsim_robot.shapes import CORNERS

DENSITY = 1000.0  # kg/m³, density of a robot whose file has no masses
SHARE = 0.005  # share of the total mass for all bodies without mass together
NOTHING = 1e-9  # share of the total mass that counts as no mass
SMALL = 0.05  # smallest size of a body without shapes, as a share of the robot's size
LONG = 0.15  # length of a capsule at the end of a limb, as a share of the robot's size
SLIM = 0.1  # radius of a capsule along a link, as a share of its length
MESHES = 500  # of a robot
VERTICES_OF_SHAPES = 1_000_000  # of all meshes, each counted as often as it is used
_BITS = 2**16 - 1  # mask of contact bits
WIDE, NARROW = 3.0, 0.01  # limits of the radius of gyration, as a share of a body's size


def repair_shapes(robot: RobotTree) -> None:
    """Replace meshes with hulls, and add shapes to bodies without colliding shapes.

    Without colliding shapes, the trunk, the ends of limbs and bodies with missing meshes collide
    with their visible geometry or a capsule. Other bodies lack colliding shapes on purpose, so
    their shapes are only drawn.
    """
    bodies = list(robot.root.walk())
    if not any(body.mass or body.shapes for body in bodies):
        raise RobotError(
            "the robot has no mass: its links have neither mass nor geometry",
            where=robot.name,
            remedy="add the masses of the links to the file",
        )
    nothing = not any(body.colliding for body in bodies)
    visible: list[str] = []
    capsules: list[str] = []
    flat: list[str] = []
    length = robot_size(robot)
    _check_meshes(robot)
    meshes = sum(shape.vertices is not None for body in bodies for shape in body.colliding)
    if meshes:
        robot.repairs.append(f"meshes replaced by convex hulls: {meshes}")
    for body in bodies:
        if body.colliding:
            body.shapes = body.colliding
        elif not body.pulley:
            solid = nothing or body is robot.root or not body.children or body.lost
            if body.shapes:
                visible += [body.name] * solid
            elif (capsule := _capsule(body, length)) is not None:
                body.shapes = [capsule]
                capsules.append(body.name)
            for shape in body.shapes:
                shape.collides = solid
                shape.contype = shape.conaffinity = int(solid)
        vertices = VERTICES if body.children else 2 * VERTICES  # more for feet
        body.shapes = [_simple(shape, vertices, body.name, flat) for shape in body.shapes]
    _reserve_ground(robot)
    if robot.root.incomplete:
        robot.warnings.append(
            f"meshes of the trunk {robot.root.name!r} are missing, so its shape is incomplete; "
            "copy them next to the file, or name their folder with --root"
        )
    report(robot.repairs, "visible geometry used for collisions, as there is no other", visible)
    report(robot.repairs, "without geometry, a capsule assumed", capsules)
    report(robot.repairs, "flat meshes replaced by boxes", flat)


def _check_meshes(robot: RobotTree) -> None:
    """Check that the hulls of all meshes can be computed within seconds."""
    meshes = [
        len(shape.vertices)
        for body in robot.root.walk()
        for shape in body.colliding or body.shapes
        if shape.vertices is not None
    ]
    check_vertices(sum(meshes), robot.name, VERTICES_OF_SHAPES)
    remedy = "replace most of them by boxes, cylinders and spheres"
    check_count(len(meshes), MESHES, "meshes", robot.name, remedy)


def _reserve_ground(robot: RobotTree) -> None:
    """Let all colliding shapes touch the ground (bit 1), and each other as in the file."""
    shapes = [shape for body in robot.root.walk() for shape in body.colliding]
    if all((shape.contype, shape.conaffinity) == (1, 1) for shape in shapes):
        return
    for shape in shapes:
        shape.contype = 1 | (shape.contype << 1) & _BITS
        shape.conaffinity = (shape.conaffinity << 1) & _BITS


def _simple(shape: Shape, most: int, name: str, flat: list[str]) -> Shape:
    """Return a shape with a mesh of few vertices, or a box for a flat mesh."""
    if shape.vertices is None:
        return shape
    vertices = hull(shape.vertices, most)
    if vertices is not None:
        shape.vertices = shape.place.point(vertices)
        shape.place = Place()
        return shape
    flat.append(name)
    thinnest = 0.005 * float(np.ptp(shape.vertices, axis=0).max()) or 1e-3
    place, size = box(shape.vertices, thinnest)
    bits = shape.collides, shape.contype, shape.conaffinity
    return Shape("box", shape.place @ place, size, None, *bits)


def robot_size(robot: RobotTree) -> float:
    """Return the size of the robot, the extent of its bodies' origins and shapes, m."""
    points: list[Floats] = []

    def visit(body: Body, outer: Place) -> None:
        place = outer @ body.place
        points.append(place.position)
        points.extend(place.point(shape.place.position) for shape in body.shapes)
        points.append(place.point(body.centre))
        for child in body.children:
            visit(child, place)

    visit(robot.root, Place())
    return float(np.ptp(np.array(points), axis=0).max()) or 0.1


def _capsule(body: Body, length: float) -> Shape | None:
    """Return a capsule from a body's origin to its child, or through its centre of mass.

    Returns:
        The capsule. For a body without length, a sphere at the end of a limb, otherwise None.
    """
    ends = [child.place.position for child in body.children] or [2 * body.centre]
    end = max(ends, key=lambda one: float(np.linalg.norm(one)))
    far = float(np.linalg.norm(end))
    if not body.children and far > (limit := LONG * length):  # its centre of mass may be a guess
        end, far = end * (limit / far), limit
    if far < 1e-3 * length:
        return Shape("sphere", Place(), np.array([0.02 * length])) if not body.children else None
    radius = SLIM * far
    along = end / far
    other = np.eye(3)[int(np.abs(along).argmin())]
    side = np.cross(other, along)
    side /= np.linalg.norm(side)
    turned = np.column_stack([side, np.cross(along, side), along])
    return Shape("capsule", Place(end / 2, turned), np.array([radius, far / 2]))


def repair_origin(robot: RobotTree) -> None:
    """Move an origin outside the trunk, such as that of `base_footprint`, to its middle.

    A fall is detected by the height of the origin.
    """
    trunk = robot.root
    if not trunk.shapes:
        return
    points = np.vstack([_corners(shape) for shape in trunk.shapes])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    if (np.abs(middle) <= np.ptp(points, axis=0)).all():
        return
    here = Place(middle)
    back = here.inverse()
    trunk.place = trunk.place @ here
    trunk.centre = back.point(trunk.centre)
    for shape in trunk.shapes:
        shape.place = back @ shape.place
    for child in trunk.children:
        child.place = back @ child.place
    trunk.sites = {name: back @ place for name, place in trunk.sites.items()}
    if robot.stand is not None:
        place, angles = robot.stand
        robot.stand = place @ here, angles
    robot.repairs.append(
        f"the trunk's origin moved to its middle, by {np.linalg.norm(middle):.3g} m"
    )


def repair_masses(robot: RobotTree) -> None:
    """Give every body a mass and a physically possible inertia."""
    bodies = list(robot.root.walk())
    total = sum(body.mass for body in bodies)
    if total <= 0:
        for body in bodies:
            volume, body.centre = _volume(body)
            body.mass = DENSITY * volume
            body.inertia = np.zeros((3, 3))
        total = sum(body.mass for body in bodies)
        robot.repairs.append(
            f"no masses: {total:.3g} kg assumed from the geometry at {DENSITY:.0f} kg/m³"
        )
    light = [body for body in bodies if body.mass <= NOTHING * total]
    for body in light:
        body.mass = min(0.001, SHARE / len(light)) * total
        _, body.centre = _volume(body)
        body.inertia = np.zeros((3, 3))
    if light:
        what = f"links without mass, {light[0].mass:.2g} kg each assumed"
        report(robot.repairs, what, [body.name for body in light])
    length = robot_size(robot)
    changed: list[str] = []
    balanced: list[str] = []
    for body in bodies:
        size = _size(body) if body.shapes else max(_size(body), SMALL * length)
        if not (body.pulley or _plausible(body, size)):
            body.inertia = _uniform_inertia(body, size)
            if body not in light:
                changed.append(body.name)
        values, axes = np.linalg.eigh(body.inertia)
        if values[0] + values[1] < values[2] * (1 - 1e-6):
            balanced.append(body.name)
            values[:] = values.mean()
        # Leave a margin, as rounding in the text could make a borderline inertia impossible.
        values[:2] += max(0.0, (1.001 * values[2] - values[0] - values[1]) / 2)
        body.inertia = axes @ np.diag(values) @ axes.T
    report(robot.repairs, "inertias replaced by those of uniform solids", changed)
    report(robot.repairs, "impossible inertias replaced by their mean", balanced)


def _plausible(body: Body, size: float) -> bool:
    values = np.linalg.eigvalsh(body.inertia)
    if values[0] <= 0:
        return False
    radius = math.sqrt(float(values[2]) / body.mass)
    return NARROW * size <= radius <= WIDE * size


def _uniform_inertia(body: Body, size: float) -> Floats:
    """Return the inertia of a uniform box around the body's shapes, or of a sphere of its size."""
    points = [_corners(shape) for shape in body.shapes]
    if not points:
        return body.mass * 0.4 * (size / 2) ** 2 * np.eye(3)
    spread = np.maximum(np.ptp(np.vstack(points), axis=0), 0.05 * size)
    squares = spread**2
    return np.diag(body.mass / 12 * (squares.sum() - squares))


def _size(body: Body) -> float:
    points = [_corners(shape) for shape in body.shapes]
    points += [child.place.position[None] for child in body.children]
    if not points:
        return 0.0
    points.append(body.centre[None])
    return float(np.linalg.norm(np.ptp(np.vstack(points), axis=0)))


def _corners(shape: Shape) -> Floats:
    """Return points that bound a shape, in the frame of its body, (n, 3) m."""
    if shape.vertices is not None:
        return shape.place.point(shape.vertices)
    return shape.place.point(CORNERS * _half(shape))


def _half(shape: Shape) -> Floats:
    """Return the half lengths of the box around a shape, along the shape's axes, (3,) m."""
    size = shape.size
    match shape.kind:
        case "sphere":
            return np.full(3, size[0])
        case "cylinder":
            return np.array([size[0], size[0], size[1]])
        case "capsule":
            return np.array([size[0], size[0], size[0] + size[1]])
    return size


def _volume(body: Body) -> tuple[float, Floats]:
    """Return the volume of a body's shapes, m³, and its centre, (3,) m."""
    total, moment = 0.0, np.zeros(3)
    for shape in body.shapes:
        centre = shape.place.position
        if shape.vertices is not None:
            volume = float(ConvexHull(shape.vertices).volume)
            centre = shape.place.point(shape.vertices.mean(0))
        else:
            volume = _solid_volume(shape)
        total += volume
        moment = moment + volume * centre
    return total, moment / total if total else np.zeros(3)


def _solid_volume(shape: Shape) -> float:
    size = shape.size
    match shape.kind:
        case "box":
            return float(8 * size.prod())
        case "ellipsoid":
            return float(4 / 3 * math.pi * size.prod())
    ball = 4 / 3 * math.pi * size[0] ** 3
    rod = 2 * math.pi * size[0] ** 2 * size[1] if len(size) > 1 else 0.0
    return float({"sphere": ball, "cylinder": rod}.get(shape.kind, ball + rod))
