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

from gaitsim.gait.gait_files import check_folder
from gaitsim.individual import Individual
from gaitsim.render.colours import LEFT, MIDDLE, RIGHT, is_damaged, sides
from gaitsim.render.meshes import Mesh, mesh_of, polyhedron, rod, slab
from gaitsim.render.scene.camera import Points
from gaitsim.render.scene.clip import Clip, clip_of
from gaitsim.render.scene.pixels import TINT
from gaitsim.render.scene.themes import THEMES, mix, rgb
from gaitsim.runs.files.atomic import write_bytes
from gaitsim_exports.gltf.document import STILL, Document
from gaitsim_exports.gltf.ground import ground
from gaitsim_exports.gltf.rotations import rigid_rotations, rotations_from_z, without_sign_flips

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
