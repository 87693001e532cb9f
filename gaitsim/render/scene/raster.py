"""Draw solids pixel by pixel, so that intersecting parts are shown correctly.

Each pixel keeps the surface with the largest w = 1 / depth. As a function of the position in the
picture, the w of a plane is affine, and the w of a quadric is the root of a quadratic equation.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.scene.camera import NEAR, Camera, Points
from gaitsim.render.scene.solids import Round, Surface, Surfaces, rotations

FINE = 2  # samples per pixel in each direction, to smooth edges; `to_pixels` adds 2 × 2
SHADES = 64  # shades of a solid; the first is for its outline
BIAS = 1e-4  # least relative difference of depth; ties go to the first surface

Floats = NDArray[np.float32]


class Drawn(NamedTuple):
    """The visible surface at each sample of a part of the picture, from the lowest row up.

    Attributes:
        left, bottom: lower left corner of the part, whole pixels.
        nearness: 1 / depth, 0 for the background, (rows, columns) 1/m.
        paint: (1 + index of the solid) × `SHADES` + shade; 0 for the background.
        piece: distinct number for each piece that has an outline.
    """

    left: int
    bottom: int
    nearness: Floats
    paint: NDArray[np.intp]
    piece: NDArray[np.int32]


class Frame(NamedTuple):
    """The camera in the frame of a solid.

    Attributes:
        eye: position of the camera, (3,) m.
        across, up, ahead: vectors of rays, (3,): a ray is column · across + row · up + ahead per
            metre of depth.
        light: direction to the light, (3,).
    """

    eye: Points
    across: Points
    up: Points
    ahead: Points
    light: Points


def raster(
    camera: Camera,
    surfaces: Surfaces,
    poses: Points,
    light: Points,
    picture: tuple[int, int],
    margin: int,
) -> Drawn | None:
    """Draw solids.

    Args:
        camera: camera of the picture.
        surfaces: surfaces of the solids.
        poses: poses of the solids, (solids, 7).
        light: direction to the light, a unit vector, (3,).
        picture: width and height of the picture, pixels.
        margin: margin around the solids, pixels.

    Returns:
        The visible surfaces; None if no solid is in the picture.
    """
    points = surfaces.points_at(poses)
    flat, depth = camera.project(points)
    low, high = flat.min(axis=0), flat.max(axis=0)
    # The points of a round solid lie on its surface, so the outline bulges between them.
    swell = 0.02 * (high - low) + margin + 1
    (left, bottom), (right, top) = (
        np.clip(np.floor(low - swell), 0, picture).astype(int).tolist(),
        np.clip(np.ceil(high + swell), 0, picture).astype(int).tolist(),
    )
    if left >= right or bottom >= top:
        return None
    shape = (top - bottom) * FINE, (right - left) * FINE
    drawn = Drawn(
        left,
        bottom,
        np.zeros(shape, dtype=np.float32),
        np.zeros(shape, dtype=np.intp),
        np.zeros(shape, dtype=np.int32),
    )
    samples = (flat - (left, bottom)) * FINE
    nearest = np.full(len(surfaces.each), np.inf)
    np.minimum.at(nearest, surfaces.owner, depth)
    corner = (np.array([left, bottom]) - camera.centre) / (camera.scale * camera.distance)
    step = 1 / (FINE * camera.scale * camera.distance)
    eye = camera.target - camera.distance * camera.ahead
    axes = np.stack([camera.right, camera.up, camera.ahead])
    start = axes.T @ (*(corner + step / 2), 1.0)  # the ray of the first sample
    piece = 1
    for number, (turn, pose) in enumerate(zip(rotations(poses[:, 3:]), poses, strict=True)):
        if nearest[number] <= NEAR * camera.distance * 1.001:
            continue
        frame = Frame(
            (eye - pose[:3]) @ turn,
            step * camera.right @ turn,
            step * camera.up @ turn,
            start @ turn,
            light @ turn,
        )
        one = surfaces.each[number]
        paint = SHADES * (number + 1)
        _faces(drawn, frame, one, paint, piece)
        if one.rounds:
            own = samples[surfaces.owner == number]
            for quadric in one.rounds:
                box = _box(own[quadric.own], shape)
                _round(drawn, frame, quadric, box, paint, piece, one.creased)
        piece += max(len(one.faces), 3)
    return drawn


def shade(shine: Points) -> NDArray[np.int32]:
    """Return shades, 1 to `SHADES` − 1, from the cosines of the angles to the light."""
    return (1.5 + (SHADES - 2) * (0.5 + 0.5 * np.clip(shine, -1, 1)) ** 2).astype(np.int32)


def _box(points: Points, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return the rows and columns of a round piece spanned by points."""
    low, high = points.min(axis=0), points.max(axis=0)
    swell = 0.03 * (high - low) + 2
    first = np.clip(np.floor(low - swell), 0, shape[::-1]).astype(int)
    last = np.clip(np.ceil(high + swell), 0, shape[::-1]).astype(int)
    return slice(first[1], last[1]), slice(first[0], last[0])


def _faces(drawn: Drawn, frame: Frame, one: Surface, paint: int, piece: int) -> None:
    """Draw the flat faces that face the camera."""
    if not one.faces:
        return
    rays = np.stack([frame.across, frame.up, frame.ahead])
    gaps = ((one.places - frame.eye) * one.normals).sum(axis=1)
    towards = gaps < 0
    # A face seen edge-on has a gap of 0; it is not drawn, and infinity avoids a division by zero.
    slopes = one.normals @ rays.T / np.where(towards, gaps, -np.inf)[:, None]
    tones = paint + shade(one.normals @ frame.light)
    # The position of each point, as a combination of the three vectors of rays.
    seen = np.linalg.solve(rays.T, (one.points - frame.eye).T)
    outline = (seen[:2] / seen[2]).T
    for number in np.flatnonzero(towards).tolist():
        rows, columns, inside = _polygon(outline[one.faces[number]], drawn.nearness.shape)
        if not inside.size:
            continue
        nearness = _affine(slopes[number], rows, columns)
        place = rows, columns
        inside &= nearness > drawn.nearness[place] * (1 + BIAS)
        np.copyto(drawn.nearness[place], nearness, where=inside)
        np.copyto(drawn.paint[place], tones[number], where=inside)
        np.copyto(drawn.piece[place], piece + number * one.creased, where=inside)


def _affine(slopes: Points, rows: slice, columns: slice) -> Floats:
    """Return slopes · (column, row, 1) over a part of the picture."""
    across, up, here = slopes
    x = np.arange(columns.start, columns.stop) * across
    y = np.arange(rows.start, rows.stop) * up + here
    return np.asarray(np.add.outer(y.astype(np.float32), x.astype(np.float32)))


def _polygon(outline: Points, shape: tuple[int, ...]) -> tuple[slice, slice, NDArray[np.bool_]]:
    """Return the rows and columns around a convex polygon (corners, 2), and its samples there."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    first = np.maximum(np.ceil(low - 0.01), 0).astype(int)
    last = np.minimum(np.floor(high + 0.01) + 1, shape[::-1]).astype(int)
    rows, columns = slice(first[1], last[1]), slice(first[0], last[0])
    y = np.arange(first[1], last[1], dtype=np.float64)[:, None]
    x, from_y = outline.T
    to_x, to_y = np.roll(outline, -1, axis=0).T
    rise = to_y - from_y
    rise[rise == 0] = 1e-9
    at = np.clip((y - from_y) / rise, 0, 1)
    across = x + at * (to_x - x)
    # Rows beyond an edge would meet it at its nearer end; they are excluded.
    missed = (y < np.minimum(from_y, to_y) - 0.01) | (y > np.maximum(from_y, to_y) + 0.01)
    left = np.where(missed, np.inf, across).min(axis=1) - 0.01
    right = np.where(missed, -np.inf, across).max(axis=1) + 0.01
    along = np.arange(first[0], last[0], dtype=np.float64)
    return rows, columns, (along >= left[:, None]) & (along <= right[:, None])


def _round(
    drawn: Drawn,
    frame: Frame,
    quadric: Round,
    box: tuple[slice, slice],
    paint: int,
    piece: int,
    creased: bool,
) -> None:
    """Draw a round piece; its flat ends are visible only if it is creased.

    A point of nearness w on a ray is inside if c w² + 2 b w + a ≤ 0, where b is affine and a is
    quadratic in the position in the picture.
    """
    rows, columns = box
    eye = frame.eye - quadric.centre
    rays = np.stack([frame.across, frame.up, frame.ahead])
    near, scaled = eye * quadric.inverse, rays * quadric.inverse
    c, slopes = float(near @ near) - 1, scaled @ near
    square = np.outer(slopes, slopes) - c * scaled @ scaled.T
    x = np.arange(columns.start, columns.stop, dtype=np.float64)
    y = np.arange(rows.start, rows.stop, dtype=np.float64)
    by_row = square[1, 1] * y**2 + 2 * square[1, 2] * y + square[2, 2]
    seen = np.add.outer(by_row, square[0, 0] * x**2)
    seen += np.multiply.outer(2 * (square[0, 1] * y + square[0, 2]), x)
    row, column = np.nonzero(seen > 0)
    root = np.sqrt(seen[row, column])
    row, column = row + rows.start, column + columns.start
    place = np.stack([column, row, np.ones(len(row))], axis=1)
    b = place @ slopes
    nearness = (root - b) / c if c > 0 else np.full(len(b), np.inf)
    end = np.zeros(len(b), dtype=np.int32)
    inside = nearness > 0
    if np.isfinite(quadric.half):
        back = -(b + root) / (c or 1e-12)
        for side in (1, -1):
            room = quadric.half - side * float(eye[2])
            plane = place @ (side * rays[:, 2]) / (room or 1e-12)
            if room < 0:
                end[plane < nearness] = side
                nearness = np.minimum(nearness, plane)
            else:
                back = np.maximum(back, plane)
        inside &= nearness >= back
    inside &= nearness > drawn.nearness[row, column] * (1 + BIAS)
    row, column, nearness, place = row[inside], column[inside], nearness[inside], place[inside]
    square_inverse = quadric.inverse**2
    light = square_inverse * frame.light
    shine = eye @ light + place @ (rays @ light) / nearness
    largest = quadric.inverse.max()
    if np.isin(quadric.inverse, (0.0, largest)).all():  # normals of equal length
        shine /= largest
    else:
        normal = (eye + place @ rays / nearness[:, None]) * square_inverse
        shine /= np.linalg.norm(normal, axis=1)
    ends = end[inside] * creased
    shine = np.where(ends, ends * frame.light[2], shine)
    drawn.nearness[row, column] = nearness
    drawn.paint[row, column] = paint + shade(shine)
    drawn.piece[row, column] = piece + ends % 3


def to_pixels(drawn: Drawn, colours: Points, width: int) -> NDArray[np.uint8]:
    """Return the pixels of visible surfaces, with outlines.

    Args:
        drawn: the visible surfaces.
        colours: colours of each solid's shades, 0 to 1, (solids, `SHADES`, 3).
        width: width of outlines, samples.

    Returns:
        Red, green, blue and opacity, from the lowest row up, (rows, columns, 4).
    """
    nearness, paint, piece = drawn.nearness, drawn.paint.copy(), drawn.piece
    for axis in (0, 1):
        one: list[slice] = [slice(None), slice(None)]
        other = list(one)
        one[axis], other[axis] = slice(None, -width), slice(width, None)
        here, there = tuple(one), tuple(other)
        at = np.nonzero(piece[here] != piece[there])
        nearer = nearness[here][at] >= nearness[there][at]
        ink = np.where(nearer, drawn.paint[here][at], drawn.paint[there][at])
        paint[here][at] = ink // SHADES * SHADES
    table = np.zeros((len(colours) + 1, SHADES, 4), dtype=np.uint16)
    table[1:, :, :3] = np.round(255 * colours)
    table[1:, :, 3] = 255
    # Viewing the four numbers of a sample as one 64-bit integer adds them at once.
    samples = table.view(np.uint64).ravel()[paint]
    whole = samples[0::2, 0::2] + samples[0::2, 1::2]
    whole += samples[1::2, 0::2]
    whole += samples[1::2, 1::2]
    total = whole.view(np.uint16).reshape(*whole.shape, 4)
    opacity = total[..., 3]
    part = np.nonzero((opacity > 0) & (opacity < 255 * FINE**2))
    pixels = (total // FINE**2).astype(np.uint8)
    mean = np.round(total[part] * 255.0 / opacity[part][:, None]).astype(np.uint8)
    pixels[part] = np.where([True, True, True, False], mean, pixels[part])
    return np.asarray(pixels)


def shades_of(dark: Points, light: Points, ink: Points) -> Points:
    """Return the colours of solids, (solids, `SHADES`, 3): the outline, then dark to light."""
    share = np.linspace(0, 1, SHADES - 1)[:, None]
    return np.concatenate([ink[:, None], dark[:, None] * (1 - share) + light[:, None] * share], 1)
