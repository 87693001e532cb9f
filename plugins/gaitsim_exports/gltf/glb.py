"""Bodies in motion as animated glTF 2.0 files (.glb).

Blender, three.js, game engines and the viewers of operating systems open these files. The scene
is in metres. In glTF, y is up and z is forward; the root node rotates gaitsim's axes (x forward, y
left, z up) to these, and the nodes below it have gaitsim's coordinates.

Rods and solids are rigid. Between frames they turn along the shortest path, by glTF's linear
interpolation of rotations.
"""

from importlib.metadata import version
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Terrain
from gaitsim.plugin.gait import check_folder
from gaitsim.plugin.pictures import (
    LEFT,
    MIDDLE,
    RIGHT,
    THEMES,
    TINT,
    Clip,
    Mesh,
    Points,
    clip_of,
    is_damaged,
    mesh_of,
    mix,
    polyhedron,
    rgb,
    rod,
    sides,
    slab,
    steps,
)
from gaitsim.plugin.runs import Individual, write_bytes
from gaitsim_exports.gltf.document import STILL, Document

CENTRE = "centre"
"""Name of the node that moves along the body's path."""

_ROOT = "z up"
_AXES = (-0.5, -0.5, -0.5, 0.5)  # (x, y, z) becomes (y, z, x)


def write_glb(individual: Individual, path: Path) -> None:
    """Write an individual's body in motion as an animated glTF 2.0 file."""
    check_folder(path)
    write_bytes(path, glb(individual))


def glb(individual: Individual) -> bytes:
    """Return an individual's body in motion as an animated glTF 2.0 file.

    The file has a node with a mesh for each limb, plate and solid, an empty node with the name of
    each foot, an empty node for the body's centre, and the ground. The same individual gives the
    same bytes.
    """
    clip = clip_of(individual)
    score = individual.score
    # The individual's own title may contain the path of the run on this machine.
    title = f"{individual.name}, {individual.label}" if individual.generation else individual.name
    extras = {
        "title": title,
        "score": score if np.isfinite(score) else None,
        "generation": individual.generation,
        "units": {"length": "m", "time": "s", "score": individual.experiment.fitness.unit},
    }
    made = f"gaitsim {version('gaitsim')}"
    return _Body(clip).document.to_glb(individual.name, made, title, extras)


class _Body:
    """The glTF document of a clip."""

    def __init__(self, clip: Clip) -> None:
        self.clip, self.theme = clip, THEMES["light"]
        skeleton = clip.skeleton
        frames = len(skeleton.segments)
        times = np.arange(frames) / skeleton.frame_rate
        self.document = Document(times, _ROOT, _AXES)
        self._materials: dict[tuple[str, bool], int] = {}
        self._shapes: dict[Any, Any] = {}
        self._meshes: dict[Any, int] = {}
        segments = skeleton.segments.astype(np.float64)
        if skeleton.solids:
            self._add_solids()
        else:
            self._add_limbs(segments)
            self._add_plates(segments.reshape(frames, -1, 3))
        names = skeleton.contact_names
        if skeleton.contacts is not None:
            feet = np.asarray(skeleton.contacts, dtype=np.float64)
            for foot in range(feet.shape[1]):
                name = names[foot] if names else f"foot {foot + 1}"
                self.document.add_node(name, translation=feet[:, foot])
        self.document.add_node(CENTRE, translation=np.asarray(skeleton.path, dtype=np.float64))
        self._add_ground()

    def _add_limbs(self, segments: Points) -> None:
        """Add each limb as a rod centred at its middle."""
        anatomy, names = self.clip.anatomy, self.clip.skeleton.names
        hues = self._hues([names[limb] for limb in anatomy.limbs])
        hues = np.where(anatomy.trunks, "body", hues)
        hues = np.where(anatomy.damaged, "damaged", hues)
        self._add_rods(anatomy.limbs.tolist(), segments, anatomy.radii, hues.tolist())

    def _add_rods(self, which: list[int], segments: Points, radii: Points, hues: list[str]) -> None:
        ends = segments[:, which]
        reach = ends[:, :, 1] - ends[:, :, 0]
        lengths = np.linalg.norm(reach, axis=-1)
        turns = rotations_from_z(reach / np.maximum(lengths, 1e-30)[..., None])
        usual = np.maximum(np.median(lengths, axis=0), 1e-9)
        scales = np.ones_like(reach)
        scales[..., 2] = np.maximum(lengths / usual, STILL)
        for i, segment in enumerate(which):
            # Rods that differ only by rounding share a mesh.
            key = ("rod", *(float(f"{size:.6g}") for size in (*radii[i], usual[i])))
            self.document.add_node(
                self.clip.skeleton.names[segment],
                self._mesh(key, lambda key=key: rod(*key[1:]), hues[i]),
                translation=ends[:, i].mean(axis=1),
                rotation=turns[:, i],
                scale=scales[:, i],
            )

    def _add_plates(self, ends: Points) -> None:
        """Add plates and the solids framed by segments."""
        anatomy = self.clip.anatomy
        for plate, half in zip(anatomy.plates, anatomy.plate_radii, strict=True):
            self._add_framed(ends, [*plate], lambda corners, half=half: slab(corners, half), "body")
        for faces in anatomy.solids:
            corners = sorted({corner for face in faces for corner in face})
            places = [[corners.index(corner) for corner in face] for face in faces]
            self._add_framed(
                ends, corners, lambda points, places=places: polyhedron(points, places), "limb"
            )

    def _add_framed(self, ends: Points, corners: list[int], shape: Any, hue: str) -> None:
        """Add a shape whose corners are ends of segments, as a rigid body or else as rods."""
        places = ends[:, corners]
        path = np.asarray(self.clip.skeleton.path, dtype=np.float64)[:, None]
        # Rotate about the corner that moves least, such as a wing's hinge.
        pivot = places[:, int(np.var(places - path, axis=0).sum(axis=1).argmin())]
        places = places - pivot[:, None]
        turns = rigid_rotations(places)
        which = sorted({corner // 2 for corner in corners})
        if turns is None:  # the shape is not rigid
            radii = np.full((len(which), 2), self.clip.anatomy.thickness)
            segments = ends.reshape(len(ends), -1, 2, 3)
            self._add_rods(which, segments, radii, [hue] * len(which))
            return
        mesh = self._mesh(("plate", *corners), lambda: shape(places[0]), hue, thin=True)
        name = _common_words([self.clip.skeleton.names[segment] for segment in which]) or "body"
        self.document.add_node(name, mesh, translation=pivot, rotation=turns)

    def _add_solids(self) -> None:
        skeleton = self.clip.skeleton
        poses = np.asarray(skeleton.poses, dtype=np.float64)
        turns = without_sign_flips(poses[..., [4, 5, 6, 3]])
        names = [solid.name for solid in skeleton.solids]
        hues = np.where(is_damaged(names, skeleton.damaged), "damaged", self._hues(names, "body"))
        for i, solid in enumerate(skeleton.solids):
            key = (solid.shape, solid.size, i if solid.vertices is not None else None)
            mesh = self._mesh(key, lambda solid=solid: mesh_of(solid), str(hues[i]))
            self.document.add_node(
                solid.name, mesh, translation=poses[:, i, :3], rotation=turns[:, i]
            )

    def _add_ground(self) -> None:
        light, dark = ground(self.clip)
        shape = self.document.add_shape(light)
        colour = rgb(self.theme.ground)
        shaded = mix(colour, rgb(self.theme.grid), 0.3)
        shapes = {self.document.add_material("ground", colour): shape}
        if len(dark):
            number = self.document.add_material("ground, every other tile", shaded)
            shapes[number] = self.document.add_triangles(shape, dark)
        self.document.add_node("ground", self.document.add_mesh("ground", shapes))

    def _hues(self, names: list[str], middle: str = "limb") -> Any:
        words = {LEFT: "left", RIGHT: "right", MIDDLE: middle}
        return np.array([words[side] for side in sides(tuple(names)).tolist()], dtype="U7")

    def _mesh(self, key: Any, shape: Any, hue: str, thin: bool = False) -> int:
        """Return the index of the mesh of a shape in a colour; equal meshes are stored once."""
        if key not in self._shapes:
            mesh: Mesh = shape()
            self._shapes[key] = self.document.add_shape(mesh)
        if (key, hue) not in self._meshes:
            if (hue, thin) not in self._materials:
                self._materials[hue, thin] = self.document.add_material(
                    hue, self._colour(hue), thin
                )
            shapes = {self._materials[hue, thin]: self._shapes[key]}
            self._meshes[key, hue] = self.document.add_mesh(f"{key[0]}, {hue}", shapes)
        return self._meshes[key, hue]

    def _colour(self, hue: str) -> Points:
        theme = self.theme
        limb = mix(rgb(theme.limb), rgb(theme.limb_light), 0.5)
        if hue == "limb":
            return limb
        if hue in ("left", "right"):
            return mix(limb, rgb(getattr(theme, hue)), TINT)
        return rgb(theme.body(0) if hue == "body" else theme.damaged)


def _common_words(names: list[str]) -> str:
    """Return the first words that all names share, such as 'left wing'; '' for none."""
    words = [name.split() for name in names]
    same = takewhile(lambda column: len({*column}) == 1, zip(*words, strict=False))
    return " ".join(column[0] for column in same)


TILES = 40  # maximum number of tiles along the longer side


def ground(clip: Clip) -> tuple[Mesh, NDArray[np.intp]]:
    """Return the ground, with a margin of one body length around the path.

    Uneven ground includes its own corners, and extends its edges horizontally beyond them.

    Returns:
        A mesh of the tiles of one shade, and the triangles of the other shade.
    """
    path, span = np.asarray(clip.skeleton.path, dtype=np.float64)[:, :2], clip.anatomy.span
    low, high = path.min(axis=0) - span, path.max(axis=0) + span
    step = steps(float((high - low).max()) / TILES)[0]
    # Additional lines would split the triangles of a terrain.
    tiled = not isinstance(clip.skeleton.ground, Terrain)
    x, y = (
        _lines(low[axis], high[axis], step if tiled else np.inf, clip.corners[axis])
        for axis in (0, 1)
    )
    points = clip.on_ground(np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1))
    if clip.skeleton.ground is None:
        points[..., 2] = clip.floor
    first = (np.arange(len(y) - 1)[:, None] * len(x) + np.arange(len(x) - 1)).ravel()
    across, beside = first + len(x) + 1, first + 1
    pairs = np.stack([first, beside, across, first, across, first + len(x)], axis=1)
    corner, opposite = points.reshape(-1, 3)[first], points.reshape(-1, 3)[across]
    tile = np.floor((corner + opposite)[:, :2] / 2 / step).astype(np.intp)
    dark = tile.sum(axis=1) % 2 == 1
    light, other = (pairs[one].reshape(-1, 3) for one in (~dark, dark))
    return Mesh(points.reshape(-1, 3), light), other


def _lines(low: float, high: float, step: float, corners: Points) -> Points:
    """Return the positions of tile edges and corners of the ground along an axis, m."""
    inside = corners[(low < corners) & (corners < high)]
    edges = np.empty(0)
    if np.isfinite(step):
        edges = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
    lines = np.unique(np.concatenate([[low, high], edges, inside]))
    # Edges that differ only by rounding would enclose empty tiles.
    return np.asarray(lines[np.concatenate([[True], np.diff(lines) > 1e-9 * (high - low)])])


def without_sign_flips(quaternions: Points) -> Points:
    """Return quaternions (frames, …, 4) whose signs do not flip between frames."""
    turns = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=-1) < 0, -1.0, 1.0)
    signs = np.concatenate([np.ones_like(quaternions[:1, ..., 0]), np.cumprod(turns, axis=0)])
    return np.asarray(quaternions * signs[..., None])


def rotations_from_z(directions: Points) -> Points:
    """Return the rotations that align the z axis with directions, without twist between frames.

    Args:
        directions: unit vectors (frames, rods, 3); a rod of zero length, without a direction,
            keeps its rotation.

    Returns:
        The rotations, (frames, rods, 4).
    """
    from scipy.spatial.transform import Rotation

    axis = np.array([0.0, 0.0, 1.0])
    turn = Rotation.identity(directions.shape[1])
    found = np.empty((*directions.shape[:2], 4))
    for frame, wanted in enumerate(directions):
        turn = Rotation.from_quat(_arc(turn.apply(axis), wanted)) * turn
        found[frame] = turn.as_quat()
    return without_sign_flips(found)


def _arc(one: Points, other: Points) -> Points:
    """Return the shortest rotations (…, 4) from unit vectors (…, 3) to others."""
    cosine = (one * other).sum(axis=-1, keepdims=True)
    arc = np.concatenate([np.cross(one, other), 1 + cosine], axis=-1)
    # Opposite vectors need half a turn about a perpendicular axis.
    nearest = np.eye(3)[np.abs(one).argmin(axis=-1)]
    half = np.concatenate([np.cross(one, nearest), np.zeros_like(cosine)], axis=-1)
    return np.where(np.linalg.norm(arc, axis=-1, keepdims=True) < 1e-6, half, arc)


def rigid_rotations(places: Points) -> Points | None:
    """Return the rotations of points about the origin since the first frame (Kabsch 1976).

    Args:
        places: positions of the points, (frames, points, 3) m.

    Returns:
        The rotations, (frames, 4); None if the points are not rigid, or all on one line.
    """
    from scipy.spatial.transform import Rotation

    first = places[0]
    left, sizes, right = np.linalg.svd(np.einsum("fpi,pj->fij", places, first))
    if (sizes[:, 1] <= 1e-6 * sizes[:, 0]).any():
        return None
    left[..., 2] *= np.linalg.det(left @ right)[:, None]
    matrices = left @ right
    away = np.einsum("fij,pj->fpi", matrices, first) - places
    if np.abs(away).max() > 1e-4 * np.abs(first).max():
        return None
    return without_sign_flips(Rotation.from_matrix(matrices).as_quat())
