"""Draw a body as filled outlines, from back to front."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.scene.anatomy import DrawnAnatomy
from gaitsim.render.scene.camera import Camera, Points
from gaitsim.render.scene.solids import capsules, hull
from gaitsim.render.scene.themes import Colour, mix

FOG = 0.3  # share of the background's colour on the far side of a body
EDGE = 1.1  # width of an outline
LIGHT = np.array([0.3, -0.5, 0.81])  # direction to the light


Fog = Callable[[float | Points], NDArray[np.float64]]


class BodyPart(NamedTuple):
    """A filled outline: corners (corners, 2), colours, and the width of its edge, pixels."""

    outline: Points
    face: Colour
    edge: Colour
    width: float


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
    fog = partial(_fog, middle, anatomy.span)
    drawn = [
        *_limbs(camera, segments[anatomy.limbs], anatomy, colours, line, fog),
        *_plates(camera, segments.reshape(-1, 3), anatomy, colours, line, fog),
        *_solids(camera, segments.reshape(-1, 3), anatomy, colours, line, fog),
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


def _limbs(
    camera: Camera,
    segments: Points,
    anatomy: DrawnAnatomy,
    colours: Mapping[str, Colour],
    line: float,
    fog: Fog,
) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw limbs as round bars with a lit upper side."""
    sides, depth = _capsules(camera, segments, anatomy.radii)
    lights, _ = _capsules(camera, segments, anatomy.radii, 0.42, 0.36)
    share, trunk, hurt = fog(depth), anatomy.trunks[:, None], anatomy.damaged[:, None]
    side, light, edge = (
        mix(
            np.where(hurt, colours[bad], np.where(trunk, colours[thick], colours[thin])),
            colours["ground"],
            share,
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


def _plates(
    camera: Camera,
    ends: Points,
    anatomy: DrawnAnatomy,
    colours: Mapping[str, Colour],
    line: float,
    fog: Fog,
) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw plates as slabs with rounded corners."""
    for plate, radius in zip(anatomy.plates, anatomy.plate_radii, strict=True):
        corners = ends[list(plate)]
        normal = _normal(corners)
        normal *= -np.sign(normal @ camera.ahead)
        front, depth = camera.project(corners + radius * normal)
        back, _ = camera.project(corners - radius * normal)
        share = fog(depth.mean())
        side, light, edge = (
            mix(colours[name], colours["ground"], share)
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


def _solids(
    camera: Camera,
    ends: Points,
    anatomy: DrawnAnatomy,
    colours: Mapping[str, Colour],
    line: float,
    fog: Fog,
) -> Iterator[tuple[float, list[BodyPart]]]:
    """Draw the faces that face the camera, shaded by their angle to the light."""
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
            share = fog(depth.mean())
            colour = mix(colours["limb"], colours["limb_light"], shine)
            parts.append(
                BodyPart(
                    outline,
                    mix(colour, colours["ground"], share),
                    mix(colours["limb_edge"], colours["ground"], share),
                    EDGE * line,
                )
            )
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


def _fog(middle: float, span: float, depth: float | Points) -> NDArray[np.float64]:
    """Return the share of background colour at a depth; `middle` is the depth of the body."""
    return np.asarray(FOG * np.clip((depth - middle) / span + 0.5, 0.0, 1.0))


def _normal(corners: Points) -> Points:
    """Return the unit normal of a polygon (corners, 3), of which some corners may be collinear."""
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners - corners[0], after - corners[0]).sum(axis=0)
    return np.asarray(normal / max(float(np.linalg.norm(normal)), 1e-12))


def _turns_left(outline: Points) -> float:
    """Return twice the signed area of a polygon (corners, 2), positive counter-clockwise."""
    x, y = outline.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
