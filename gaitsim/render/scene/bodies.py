"""The drawn shape of a skeleton: limbs, plates and solids as filled outlines, back to front."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.render.colours import is_damaged
from gaitsim.render.scene.camera import Camera, Points
from gaitsim.render.scene.solids import capsules, hull, hull_faces
from gaitsim.render.scene.themes import Colour, mix

THICKNESS = 0.13  # radius of a limb, relative to the median length of segments
SLENDER = 0.022  # maximum radius of a limb, relative to the span of the body
FREE, TRUNK = 0.6, 2.2  # radii of a free end and of a trunk, relative to the radius of a limb
_JOINT_TOLERANCE = 1e-6  # distance of segment ends that are one joint, relative to the span

Face = tuple[int, ...]
"""Corners in order: ends of segments, as indices into (segments × 2)."""


@dataclass(frozen=True, eq=False)
class DrawnAnatomy:
    """The drawn shape of a skeleton.

    Attributes:
        limbs: indices of the segments that are limbs, (limbs,).
        radii: radii of both ends of each limb, (limbs, 2) m.
        trunks: whether each limb is a trunk, which carries other limbs, (limbs,).
        damaged: whether each limb is damaged, (limbs,).
        plates: corners of closed loops, such as a body's outline or a wing.
        plate_radii: half the thickness of each plate, m.
        solids: faces of the solids framed by segments, such as a cuboid, counter-clockwise from
            outside.
        thickness: usual radius of a limb, m.
        span: largest extent of the body, m.
    """

    limbs: NDArray[np.intp]
    radii: NDArray[np.float64]
    trunks: NDArray[np.bool_]
    damaged: NDArray[np.bool_]
    plates: tuple[Face, ...]
    plate_radii: tuple[float, ...]
    solids: tuple[tuple[Face, ...], ...]
    thickness: float
    span: float


def anatomy(skeleton: Skeleton) -> DrawnAnatomy:
    """Derive the anatomy of a skeleton.

    Segments that form closed loops frame a plate or a solid. All others are limbs: thick at
    joints, thin at free ends. A segment whose ends are neither joints nor feet, such as a spine,
    is a trunk.
    """
    segments = skeleton.segments.astype(np.float64)
    lengths = np.median(np.linalg.norm(segments[:, :, 1] - segments[:, :, 0], axis=-1), axis=0)
    about = segments - np.asarray(skeleton.path, dtype=np.float64)[:, None, None]
    span = max(float(np.ptp(about.reshape(-1, 3), axis=0).max()), 1e-6)
    joints = _joints(segments, _JOINT_TOLERANCE * span)
    ends = segments[0].reshape(-1, 3)
    plates, solids, framed = [], [], set[int]()
    for frame in _frames(joints):
        loop = _loop(frame, joints)
        faces = () if loop else _faces(ends, frame)
        if loop or faces:
            framed.update(frame)
            plates += [loop] if loop else []
            solids += [faces] if faces else []
    limbs = np.array([i for i in range(len(joints)) if i not in framed], dtype=np.intp)
    usual = float(np.median(lengths[limbs])) if len(limbs) else span
    radius = max(min(THICKNESS * usual, SLENDER * span), 0.002 * span)
    shares, trunks = _relative_radii(skeleton, joints, ends, span)
    thin = [0.012 if len(plate) == 3 else 0.04 for plate in plates]
    shortest = [min(lengths[end // 2] for end in plate) for plate in plates]
    return DrawnAnatomy(
        limbs,
        radius * shares[limbs],
        trunks[limbs],
        is_damaged(skeleton.names, skeleton.damaged)[limbs],
        tuple(plates),
        tuple(float(share * length) for share, length in zip(thin, shortest, strict=True)),
        tuple(solids),
        radius,
        span,
    )


def _joints(segments: NDArray[np.float64], tolerance: float) -> NDArray[np.intp]:
    """Number the ends (segments, 2) of segments; ends that move together share a number."""
    some = segments[[0, len(segments) // 2, -1]].reshape(3, -1, 3)
    numbers = np.arange(some.shape[1])
    for end in range(some.shape[1]):
        near = (np.abs(some[:, :end] - some[:, end, None]) <= tolerance).all(axis=(0, 2))
        if near.any():
            numbers[end] = numbers[int(near.argmax())]
    return numbers.reshape(-1, 2)


def _frames(joints: NDArray[np.intp]) -> list[list[int]]:
    """Return groups of connected segments without a free end."""
    left = [i for i, (one, other) in enumerate(joints) if one != other]
    while True:
        counts = np.bincount(joints[left].ravel(), minlength=joints.size)
        closed = [i for i in left if counts[joints[i]].min() > 1]
        if len(closed) == len(left):
            break
        left = closed
    groups: list[list[int]] = []
    for segment in left:
        touched = [g for g in groups if np.isin(joints[g], joints[segment]).any()]
        groups = [g for g in groups if g not in touched]
        groups.append(sorted([segment, *(i for group in touched for i in group)]))
    return sorted(groups)


def _loop(frame: list[int], joints: NDArray[np.intp]) -> Face:
    """Return the corners of a simple loop in order; () if segments branch."""
    if len(frame) < 3 or len(np.unique(joints[frame])) != len(frame):
        return ()
    rest = list(frame)
    corners, at = [], joints[rest[0], 0]
    while rest:
        found = [(i, end) for i in rest for end in (0, 1) if joints[i, end] == at]
        if not found:
            return ()
        segment, end = found[0]
        corners.append(2 * segment + end)
        at = joints[segment, 1 - end]
        rest.remove(segment)
    return tuple(corners)


def _faces(ends: NDArray[np.float64], frame: list[int]) -> tuple[Face, ...]:
    """Return the faces of the convex hull of a group's ends; () if it has no volume."""
    own = np.array([2 * segment + end for segment in frame for end in (0, 1)])
    return tuple(tuple(own[corners].tolist()) for corners in hull_faces(ends[own]))


def _relative_radii(
    skeleton: Skeleton, joints: NDArray[np.intp], ends: NDArray[np.float64], span: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the relative radii (segments, 2) of the ends, and which segments are trunks."""
    shared = np.bincount(joints.ravel(), minlength=joints.size)[joints] > 1
    shares = np.where(shared, 1.0, FREE)
    if skeleton.contacts is None:
        return shares, np.zeros(len(joints), dtype=np.bool_)
    feet = skeleton.contacts[0].astype(np.float64)
    foot = (np.linalg.norm(ends[:, None] - feet, axis=-1) < 1e-3 * span).any(axis=1)
    foot = foot.reshape(-1, 2)
    trunks = ~(shared | foot).any(axis=1)
    shares[~foot] = 1.0
    shares[trunks] = TRUNK
    return shares, trunks


FOG = 0.3  # share of the background's colour on the far side of a body
EDGE = 1.1  # width of an outline
LIGHT = np.array([0.3, -0.5, 0.81])  # direction to the light


class BodyPart(NamedTuple):
    """A filled outline: corners (corners, 2), colours, and the width of its edge, pixels."""

    outline: Points
    face: Colour
    edge: Colour
    width: float


class _Drawing(NamedTuple):
    """A body in a picture; see `body`. `middle` is the depth of the body."""

    camera: Camera
    anatomy: DrawnAnatomy
    colours: Mapping[str, Colour]
    line: float
    middle: float

    def faded(self, colour: Colour, depth: float | Points) -> NDArray[np.float64]:
        """Return a colour mixed with the background's colour, which increases with the depth."""
        share = FOG * np.clip((depth - self.middle) / self.anatomy.span + 0.5, 0.0, 1.0)
        return mix(colour, self.colours["ground"], share)


def body(
    camera: Camera,
    segments: Points,
    anatomy: DrawnAnatomy,
    colours: Mapping[str, Colour],
    line: float,
) -> list[BodyPart]:
    """Return limbs, plates and solids, from back to front.

    Args:
        camera: camera of the picture.
        segments: (segments, 2, 3) m.
        anatomy: drawn shape of the body.
        colours: colours by their names in the theme.
        line: width of a line of width 1, pixels.
    """
    middle = float(camera.project(segments.mean(axis=(0, 1)))[1])
    drawing = _Drawing(camera, anatomy, colours, line, middle)
    ends = segments.reshape(-1, 3)
    drawn = [
        *_limbs(drawing, segments[anatomy.limbs]),
        *_plates(drawing, ends),
        *_solids(drawing, ends),
    ]
    drawn.sort(key=lambda one: -one[0])
    return [part for _, parts in drawn for part in parts]


def shadow(camera: Camera, flat: Points, anatomy: DrawnAnatomy) -> list[Points]:
    """Return the outlines of a body's shadow under light from above.

    Args:
        camera: camera of the picture.
        flat: segments of the body, projected onto the ground, (segments, 2, 3) m.
        anatomy: drawn shape of the body.
    """
    ends = flat.reshape(-1, 3)
    outlines = list(_capsules(camera, flat[anatomy.limbs], anatomy.radii)[0])
    outlines += [camera.project(ends[list(plate)])[0] for plate in anatomy.plates]
    for faces in anatomy.solids:
        corners = sorted({corner for face in faces for corner in face})
        outlines.append(hull(camera.project(ends[corners])[0]))
    return outlines


def _limbs(drawing: _Drawing, segments: Points) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw limbs as round bars with a lit upper side."""
    camera, anatomy, colours, line, _ = drawing
    sides, depth = _capsules(camera, segments, anatomy.radii)
    lights, _ = _capsules(camera, segments, anatomy.radii, 0.42, 0.36)
    trunk, hurt = anatomy.trunks[:, None], anatomy.damaged[:, None]
    side, light, edge = (
        drawing.faded(
            np.where(hurt, colours[bad], np.where(trunk, colours[thick], colours[thin])), depth
        )
        for thick, thin, bad in (
            ("body", "limb", "damaged"),
            ("body_light", "limb_light", "damaged_light"),
            ("limb_edge", "limb_edge", "limb_edge"),
        )
    )
    # Limbs begin on the middle line of a trunk, so the trunk is drawn over them.
    depth = depth - anatomy.span * anatomy.trunks
    for i in range(len(segments)):
        yield (
            float(depth[i]),
            [
                BodyPart(sides[i], side[i], edge[i], EDGE * line),
                BodyPart(lights[i], light[i], light[i], 0.0),
            ],
        )


def _plates(drawing: _Drawing, ends: Points) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw plates as slabs with rounded corners."""
    camera, anatomy, colours, line, _ = drawing
    for plate, radius in zip(anatomy.plates, anatomy.plate_radii, strict=True):
        corners = ends[list(plate)]
        normal = _normal(corners)
        normal *= -np.sign(normal @ camera.ahead)
        front, depth = camera.project(corners + radius * normal)
        back, _ = camera.project(corners - radius * normal)
        side, light, edge = (
            drawing.faded(colours[name], depth.mean())
            for name in ("body", "body_light", "limb_edge")
        )
        around = hull(np.concatenate([front, back]))
        rounding = 2 * radius * camera.scale
        yield (
            float(depth.mean()),
            [
                BodyPart(around, edge, edge, rounding + 2 * EDGE * line),
                BodyPart(around, side, side, rounding),
                BodyPart(front, light, light, 0.3 * rounding),
            ],
        )


def _solids(drawing: _Drawing, ends: Points) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw the faces that face the camera, shaded by their angle to the light."""
    camera, anatomy, colours, line, _ = drawing
    for faces in anatomy.solids:
        parts = []
        depths = []
        for face in faces:
            corners = ends[list(face)]
            outline, depth = camera.project(corners)
            depths.append(float(depth.mean()))
            if _turns_left(outline) <= 0:
                continue
            shine = 0.5 + 0.5 * float(_normal(corners) @ LIGHT)
            colour = mix(colours["limb"], colours["limb_light"], shine)
            inside, edge = (
                drawing.faded(one, depth.mean()) for one in (colour, colours["limb_edge"])
            )
            parts.append(BodyPart(outline, inside, edge, EDGE * line))
        yield float(np.mean(depths)), parts


def _capsules(
    camera: Camera, segments: Points, radii: Points, share: float = 1.0, lift: float = 0.0
) -> tuple[Points, Points]:
    """Project limbs, with radii reduced to a share and raised by `lift` radii in the picture."""
    ends, depth = camera.project(segments)
    pixels = radii * camera.scale_at(depth)
    along = ends[:, 1] - ends[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across *= np.where(across[:, 1:] < 0, -1.0, 1.0)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    ends = ends + lift * pixels[..., None] * across[:, None]
    return capsules(ends, share * pixels), depth.mean(axis=1)


def _normal(corners: Points) -> Points:
    """Return the unit normal of a polygon (corners, 3), of which some corners may be collinear."""
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners - corners[0], after - corners[0]).sum(axis=0)
    return np.asarray(normal / max(float(np.linalg.norm(normal)), 1e-12))


def _turns_left(outline: Points) -> float:
    """Return twice the signed area of a polygon (corners, 2), positive counter-clockwise."""
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
