"""Vertices of meshes, and convex hulls with few vertices."""

import re
from collections.abc import Callable, Iterator, Sequence
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from gaitsim_robot.errors import RobotError, check_count
from gaitsim_robot.importing.files import MeshError, RobotFiles
from gaitsim_robot.importing.tree import Body, Floats, Place, Shape
from gaitsim_robot.markup import LARGEST as FARTHEST, parse

VERTICES = 32  # per hull; the median of 171 meshes keeps 95 % of its volume
FLAT = 0.02  # share of the length; a thinner mesh becomes a box
CLOSE = 0.01  # share of the length, largest distance of the mesh from its hull
LARGEST = 300_000  # distinct vertices of a robot's meshes; MuJoCo takes up to 7 s for them
PLACED = 3_000_000  # vertices of a COLLADA file, counted as often as its nodes place them
NODES = 10_000  # nodes of a COLLADA file, counted likewise
CORNERS = 5000  # vertices of an exact hull, above which only the extreme ones are used
_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def decode(data: bytes, suffix: str) -> Floats:
    """Return the vertices of a mesh file, (n, 3), in the file's frame and in metres."""
    reader = _READERS.get(suffix)
    if reader is None:
        raise MeshError(
            f"{suffix or 'a file without extension'} is not one of {', '.join(_READERS)}"
        )
    try:
        vertices = reader(data)
    except (ValueError, KeyError, IndexError, RobotError) as error:
        raise MeshError(str(getattr(error, "what", error))) from None
    vertices = _distinct(vertices[(np.abs(vertices) <= FARTHEST).all(1)])
    if len(vertices) < 4:
        raise MeshError("it has fewer than four vertices")
    return vertices


def check_vertices(count: int, where: str, most: int = LARGEST) -> None:
    """Check that a robot's meshes do not take minutes to import."""
    remedy = "simplify the meshes, or replace them by boxes, cylinders and spheres"
    check_count(count, most, "vertices of meshes", where, remedy)


def count_vertices(data: bytes, suffix: str) -> int:
    """Return the number of vertices of a mesh file; 0 if MuJoCo cannot read it, either."""
    # Lines that are not numbers count, too, as MuJoCo replaces the numbers by 0.
    lines = len(re.findall(_VERTEX, data)) if suffix == ".obj" else 0
    try:
        if suffix == ".msh":
            count = int.from_bytes(data[:4], "little")
            points = np.frombuffer(data, "<f4", 3 * count, 16).reshape(-1, 3).astype(np.float64)
        else:
            points = _READERS[suffix](data)
    except (ValueError, KeyError, RobotError):
        return lines
    return len(_distinct(points)) + max(lines - len(points), 0)


def _distinct(points: Floats) -> Floats:
    """Return the different rows, (n, 3); far quicker than `np.unique` by axis."""
    rows = np.ascontiguousarray(points, np.float64).view("V24").ravel()
    found: Floats = np.unique(rows).view(np.float64).reshape(-1, 3)
    return found


def _stl(data: bytes) -> Floats:
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else 0
    if len(data) >= 84 + 50 * count and count:
        triangles = np.frombuffer(data, _STL, count, 84)
        return triangles["corners"].reshape(-1, 3).astype(np.float64)
    found = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", data)
    return np.array(found, "S32").astype(np.float64).reshape(-1, 3)


_VERTEX = rb"(?:\A|[\r\n])[ \t]*v[ \t]+"  # the beginning of a line with a vertex in an OBJ file


def _obj(data: bytes) -> Floats:
    found = re.findall(_VERTEX + rb"(\S+)[ \t]+(\S+)[ \t]+(\S+)", data)
    return np.array(found, "S32").astype(np.float64).reshape(-1, 3)


def _dae(data: bytes) -> Floats:
    """Read the vertices of COLLADA's visual scene (specification 1.4.1), in metres.

    Like RViz and Gazebo, this ignores the up axis; see `mesh_files`.
    """
    root = _without_namespaces(parse(data, "the mesh"))
    unit = root.find("asset/unit")
    metre = float(unit.get("meter", "1")) if unit is not None else 1.0
    points = {
        geometry.get("id", ""): np.vstack(list(_positions(geometry)) or [np.zeros((0, 3))])
        for geometry in root.iterfind("library_geometries/geometry")
    }
    nodes = {
        node.get("id", ""): node
        for library in ("library_visual_scenes", "library_nodes")
        for node in root.iterfind(f"{library}//node")
    }
    placed: list[Floats] = []
    pending = [(node, np.eye(4)) for node in root.iterfind("library_visual_scenes/*/node")]
    visited = vertices = 0
    while pending:
        node, outer = pending.pop()
        matrix = outer @ _matrix(node)
        targets = [name for name in _targets(node, "instance_geometry") if name in points]
        visited += 1
        vertices += sum(len(points[name]) for name in targets)
        if visited + len(pending) > NODES or vertices > PLACED:  # nodes may refer to one another
            raise MeshError("it has too many nodes or vertices")
        placed += [points[name] @ matrix[:3, :3].T + matrix[:3, 3] for name in targets]
        pending += [(child, matrix) for child in node.iterfind("node")]
        pending += [
            (nodes[name], matrix) for name in _targets(node, "instance_node") if name in nodes
        ]
    return np.vstack(placed or list(points.values()) or [np.zeros((0, 3))]) * metre


def _without_namespaces(root: Element) -> Element:
    for element in root.iter():
        element.tag = element.tag.rpartition(":")[2]
    return root


def _targets(node: Element, tag: str) -> list[str]:
    return [one.get("url", "").lstrip("#") for one in node.iterfind(tag)]


def _positions(geometry: Element) -> Iterator[Floats]:
    named = {
        one.get("source", "").lstrip("#")
        for one in geometry.iterfind("mesh/vertices/input")
        if one.get("semantic") == "POSITION"
    }
    for source in geometry.iterfind("mesh/source"):
        if source.get("id") in named:
            yield np.array(source.findtext("float_array", "").split(), float).reshape(-1, 3)


def _matrix(node: Element) -> Floats:
    matrix = np.eye(4)
    for step in node:
        if step.tag not in ("matrix", "translate", "rotate", "scale"):
            continue
        values = np.array((step.text or "").split(), float)
        part = np.eye(4)
        if step.tag == "matrix":
            part = values.reshape(4, 4)
        elif step.tag == "translate":
            part[:3, 3] = values
        elif step.tag == "scale":
            part[:3, :3] = np.diag(values)
        elif length := np.linalg.norm(values[:3]):
            turn = np.radians(values[3]) / length * values[:3]
            part[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
        matrix = matrix @ part
    return matrix


_READERS: dict[str, Callable[[bytes], Floats]] = {".stl": _stl, ".obj": _obj, ".dae": _dae}


def hull(points: Floats, most: int = VERTICES) -> Floats | None:
    """Return at most `most` points whose convex hull approximates the convex hull of all points.

    Starting from four corners, the hull grows by the farthest outside point, until no point is
    farther away than a hundredth of the length (the order of Quickhull: Barber, Dobkin and
    Huhdanpaa 1996).

    Returns:
        (n, 3); None if the points are flat.
    """
    points = np.unique(np.round(points, 9), axis=0)
    if len(points) < 4:
        return None
    centred = points - points.mean(0)
    axes = np.linalg.svd(centred.T @ centred)[0]
    extent = np.ptp(centred @ axes, axis=0)
    if extent.min() <= FLAT * extent.max():
        return None
    try:
        corners = _extreme(points[ConvexHull(points).vertices])
        chosen = _simplex(corners)
        grown = ConvexHull(corners[chosen], incremental=True)
        while len(chosen) < most:
            outside = (corners @ grown.equations[:, :3].T + grown.equations[:, 3]).max(1)
            farthest = int(outside.argmax())
            if outside[farthest] <= CLOSE * extent.max():
                break
            chosen.append(farthest)
            grown.add_points(corners[farthest : farthest + 1])
        found = corners[chosen]
        return found[ConvexHull(found).vertices]
    except QhullError:
        return None


def _extreme(corners: Floats) -> Floats:
    """Return the corners of a hull, or those farthest in 1000 directions if there are many.

    That changes the hull by about 0.2 % of its size.
    """
    if len(corners) <= CORNERS:
        return corners
    directions = np.random.default_rng(0).normal(size=(3, 1000))
    parts = np.array_split(corners, len(corners) // CORNERS)
    best = np.vstack([part[(part @ directions).argmax(0)] for part in parts])
    found: Floats = best[np.unique((best @ directions).argmax(0))]
    return found


def _simplex(points: Floats) -> list[int]:
    """Return the indices of four points that span a large volume."""
    first = int(np.linalg.norm(points - points.mean(0), axis=1).argmax())
    second = int(np.linalg.norm(points - points[first], axis=1).argmax())
    along = points[second] - points[first]
    third = int(np.linalg.norm(np.cross(points - points[first], along), axis=1).argmax())
    normal = np.cross(along, points[third] - points[first])
    fourth = int(np.abs((points - points[first]) @ normal).argmax())
    return [first, second, third, fourth]


def box(points: Floats, thinnest: float) -> tuple[Place, Floats]:
    """Return the place and half lengths of the box around points, along their principal axes."""
    middle = points.mean(0)
    axes = np.linalg.svd((points - middle).T @ (points - middle))[0]
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    along = (points - middle) @ axes
    low, high = along.min(0), along.max(0)
    return (Place(middle + axes @ ((low + high) / 2), axes), np.maximum((high - low) / 2, thinnest))


CLEARLY_CLOSER = 0.7  # ratio of the distances after and before the rotation
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # a quarter turn about x


class MeshFiles:
    """Vertices of meshes by their names in a URDF; each file is decoded once.

    Attributes:
        y_up: names of the decoded meshes that declare that y points up.
    """

    def __init__(self, files: RobotFiles, folders: Sequence[str]) -> None:
        self._files = files
        self._folders = folders
        self._decoded: dict[str, Floats | None] = {}
        self.y_up: set[str] = set()

    def vertices(self, name: str) -> Floats | None:
        """Return the vertices, (n, 3) m, or None if the mesh cannot be used."""

        def read(data: bytes, suffix: str) -> Floats:
            if suffix == ".dae" and b"Y_UP" in data:
                self.y_up.add(name)
            return decode(data, suffix)

        if name not in self._decoded:
            self._decoded[name] = self._files.load_mesh(name, self._folders, read)
        return self._decoded[name]


def turn_up(shapes: Sequence[tuple[Body, Shape]]) -> bool:
    """Rotate y-up meshes to z up if that brings them clearly closer to the centres of mass.

    Most URDFs were written for programs that ignore a mesh's up axis, and some for programs that
    apply it. All meshes of a robot are treated alike.

    Returns:
        Whether the meshes were rotated.
    """
    pairs = [(body, shape) for body, shape in shapes if body.mass > 0]

    def distance(turned: Floats) -> float:
        total = 0.0
        for body, shape in pairs:
            assert shape.vertices is not None
            vertices = shape.place.point(shape.vertices @ turned.T)
            middle = (vertices.min(0) + vertices.max(0)) / 2
            total += float(np.linalg.norm(middle - body.centre))
        return total

    if not pairs or distance(_Y_UP) > CLEARLY_CLOSER * distance(np.eye(3)):
        return False
    for _, shape in shapes:
        assert shape.vertices is not None
        shape.vertices = shape.vertices @ _Y_UP.T
    return True
