"""The meshes to which a URDF refers."""

from collections.abc import Sequence
from pathlib import PurePosixPath

import numpy as np

from gaitsim_robot.importing.files import Files
from gaitsim_robot.importing.meshes import MeshError, decode
from gaitsim_robot.importing.tree import Body, Floats, Shape

CLEARLY_CLOSER = 0.7  # ratio of the distances after and before the rotation
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # a quarter turn about x


class MeshFiles:
    """Vertices of meshes by their names in a URDF; each file is decoded once.

    Attributes:
        missing: reasons why meshes cannot be used, by the names of their files.
    """

    def __init__(self, files: Files, folders: Sequence[str]) -> None:
        self._files = files
        self._folders = folders
        self._decoded: dict[str, Floats | None] = {}
        self._y_up: set[str] = set()
        self.missing: dict[str, str] = {}

    def vertices(self, name: str) -> Floats | None:
        """Return the vertices, (n, 3) m, or None after recording the reason in `missing`."""
        if name not in self._decoded:
            self._decoded[name] = self._read(name)
        return self._decoded[name]

    def is_y_up(self, name: str) -> bool:
        """Return whether a mesh that was read declares that y points up."""
        return name in self._y_up

    def _read(self, name: str) -> Floats | None:
        path = self._files.find(name, self._folders)
        short = PurePosixPath(name).name[:60]
        if path is None:
            self.missing[short] = "not found"
            return None
        data = self._files.read(path)
        if path.suffix.lower() == ".dae" and b"Y_UP" in data:
            self._y_up.add(name)
        try:
            return decode(data, path.suffix)
        except MeshError as error:
            self.missing[short] = str(error)
            return None


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
