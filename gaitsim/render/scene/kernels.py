"""Fill the samples of solids and lines; compiled code that runs beside other threads.

A robot of 20 capsules takes 8 ms; operations on whole arrays took 40 ms, as they compute every
sample of the box around a slanted limb.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.render.scene.solids import BIAS, FINE, SHADES, Drawn, Pieces

Floats = NDArray[np.float64]


@njit(nogil=True, cache=True, error_model="numpy")
def fill(drawn: Drawn, pieces: Pieces, samples: Floats, frames: Floats, shown: Any) -> None:
    """Draw solids.

    Args:
        drawn: the surfaces, which are changed.
        pieces: pieces of the solids.
        samples: positions of the solids' points in `drawn`, (points, 2) samples.
        frames: the camera in the frame of each solid, (solids, 5, 3): its position, m; the vectors
            of rays, where a ray is column · across + row · up + ahead per metre of depth; and the
            direction to the light.
        shown: whether to draw each solid, (solids,).
    """
    piece = 1
    for solid in range(len(shown)):
        if not shown[solid]:
            continue
        paint = SHADES * (solid + 1)
        first, last = pieces.faces[solid], pieces.faces[solid + 1]
        for face in range(first, last):
            number = piece + (face - first) * pieces.creased[solid]
            _face(drawn, pieces, face, samples, frames[solid], paint, number)
        for one in range(pieces.rounds[solid], pieces.rounds[solid + 1]):
            _round(drawn, pieces, one, samples, frames[solid], paint, piece, pieces.creased[solid])
        piece += max(last - first, 3)


@njit(error_model="numpy")
def _dot(one: Any, other: Any) -> Any:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@njit(error_model="numpy")
def _shade(shine: Any) -> Any:
    """Return the shade, 1 to `SHADES` − 1, from the cosine of the angle to the light."""
    bright = 0.5 + 0.5 * min(max(shine, -1.0), 1.0)
    return np.int32(1.5 + (SHADES - 2) * bright * bright)


@njit(error_model="numpy")
def _face(
    drawn: Drawn, pieces: Pieces, face: int, samples: Floats, frame: Floats, paint: int, piece: int
) -> None:
    """Draw a flat face if it faces the camera; its nearness is affine in the position."""
    normal = pieces.normals[face]
    gap = _dot(pieces.places[face], normal) - _dot(frame[0], normal)
    if gap >= 0:
        return
    across, up, here = (
        _dot(normal, frame[1]) / gap,
        _dot(normal, frame[2]) / gap,
        _dot(normal, frame[3]) / gap,
    )
    tone = paint + _shade(_dot(normal, frame[4]))
    corners = pieces.points[pieces.corners[face] : pieces.corners[face + 1]]
    rows, columns = drawn.nearness.shape
    low, high = np.inf, -np.inf
    for corner in corners:
        low, high = min(low, samples[corner, 1] - 0.5), max(high, samples[corner, 1] - 0.5)
    for row in range(max(int(np.ceil(low - 0.01)), 0), min(int(np.floor(high + 0.01)) + 1, rows)):
        left, right = np.inf, -np.inf
        for number in range(len(corners)):
            one, other = samples[corners[number - 1]], samples[corners[number]]
            y, rise = row - (one[1] - 0.5), other[1] - one[1]
            if min(0.0, rise) - 0.01 <= y <= max(0.0, rise) + 0.01:
                share = min(max(y / (rise if rise else 1e-9), 0.0), 1.0)
                x = one[0] - 0.5 + share * (other[0] - one[0])
                left, right = min(left, x - 0.01), max(right, x + 0.01)
        if left > right:
            continue
        for column in range(max(int(np.ceil(left)), 0), min(int(np.floor(right)) + 1, columns)):
            nearness = np.float32(column * across + row * up + here)
            if nearness > drawn.nearness[row, column] * (1 + BIAS):
                drawn.nearness[row, column] = nearness
                drawn.paint[row, column] = tone
                drawn.piece[row, column] = piece


@njit(error_model="numpy")
def _round(
    drawn: Drawn,
    pieces: Pieces,
    one: int,
    samples: Floats,
    frame: Floats,
    paint: int,
    piece: int,
    creased: bool,
) -> None:
    """Draw a round piece; its flat ends are visible only if it is creased.

    A point of nearness w on a ray is inside if c w² + 2 b w + a ≤ 0, where b is affine and a is
    quadratic in the position in the picture.
    """
    inverse, half = pieces.inverses[one], pieces.halves[one]
    eye, slopes, square, c = _outline(frame, inverse, pieces.centres[one])
    top, bottom, left, right = _bounds(samples, pieces.spans[one], drawn)
    curved, share = square[0, 0], 1 / (c if c else 1e-12)
    above, below = half - eye[2], half + eye[2]
    at_above, at_below = 1 / (above if above else 1e-12), -1 / (below if below else 1e-12)
    for row in range(bottom, top):
        middle = square[0, 1] * row + square[0, 2]
        constant = square[1, 1] * row * row + 2 * square[1, 2] * row + square[2, 2]
        slope = slopes[1] * row + slopes[2]
        first, last = _between_roots(curved, middle, constant, left, right)
        for column in range(first, last):
            seen = curved * column * column + 2 * middle * column + constant
            if seen <= 0:
                continue
            root, b = np.sqrt(seen), slopes[0] * column + slope
            nearness = (root - b) * share if c > 0 else np.inf
            hidden, end = drawn.nearness[row, column] * (1 + BIAS), 0
            if nearness <= hidden:  # the ends only cut away
                continue
            if half < np.inf:
                along = frame[1, 2] * column + frame[2, 2] * row + frame[3, 2]
                back = max(-(b + root) * share, 0.0)
                if above >= 0:
                    back = max(back, along * at_above)
                elif along * at_above < nearness:
                    nearness, end = along * at_above, 1
                if below >= 0:
                    back = max(back, along * at_below)
                elif along * at_below < nearness:
                    nearness, end = along * at_below, -1
                if nearness < back or nearness <= hidden:
                    continue
            if end and creased:
                shine = end * frame[4, 2]
            else:
                shine = _shine(frame, eye, inverse, column, row, 1 / nearness)
            drawn.nearness[row, column] = nearness
            drawn.paint[row, column] = paint + _shade(shine)
            drawn.piece[row, column] = piece + (end % 3 if creased else 0)


@njit(error_model="numpy")
def _outline(frame: Floats, inverse: Floats, centre: Floats) -> Any:
    """Return the eye relative to a quadric, the slopes of b, the matrix of b² − a c, and c."""
    # Loops compile in half of the time of operations on whole arrays.
    eye, near, slopes = np.empty(3), np.empty(3), np.empty(3)
    scaled, square = np.empty((3, 3)), np.empty((3, 3))
    for i in range(3):
        eye[i] = frame[0, i] - centre[i]
        near[i] = eye[i] * inverse[i]
        for ray in range(3):
            scaled[ray, i] = frame[1 + ray, i] * inverse[i]
    c = _dot(near, near) - 1
    for i in range(3):
        slopes[i] = _dot(scaled[i], near)
    for i in range(3):
        for j in range(3):
            square[i, j] = slopes[i] * slopes[j] - c * _dot(scaled[i], scaled[j])
    return eye, slopes, square, c


@njit(error_model="numpy")
def _between_roots(
    square: float, middle: float, constant: float, left: int, right: int
) -> tuple[int, int]:
    """Narrow columns to those where square · x² + 2 middle · x + constant may be positive."""
    if square >= 0:
        return left, right
    inside = middle * middle - square * constant
    if inside <= 0:
        return left, left
    width, centre = np.sqrt(inside) / -square, middle / -square
    first = int(min(max(centre - width - 1, left), right))
    return first, int(min(max(centre + width + 2, first), right))


@njit(error_model="numpy")
def _shine(
    frame: Floats, eye: Floats, inverse: Floats, column: int, row: int, depth: float
) -> float:
    """Return the cosine of the angle between a quadric's normal and the light."""
    along, length = 0.0, 0.0
    for i in range(3):
        ray = frame[1, i] * column + frame[2, i] * row + frame[3, i]
        normal = (eye[i] + ray * depth) * inverse[i] * inverse[i]
        along += normal * frame[4, i]
        length += normal * normal
    return float(along / np.sqrt(length))


@njit(error_model="numpy")
def _bounds(samples: Floats, span: Any, drawn: Drawn) -> tuple[int, int, int, int]:
    """Return the top, bottom, left and right of a round piece spanned by points."""
    rows, columns = drawn.nearness.shape
    left, right, bottom, top = np.inf, -np.inf, np.inf, -np.inf
    for point in range(span[0], span[1]):
        left, right = min(left, samples[point, 0]), max(right, samples[point, 0])
        bottom, top = min(bottom, samples[point, 1]), max(top, samples[point, 1])
    wide, tall = 0.03 * (right - left) + 2, 0.03 * (top - bottom) + 2
    return (
        int(min(max(np.ceil(top + tall), 0), rows)),
        int(min(max(np.floor(bottom - tall), 0), rows)),
        int(min(max(np.floor(left - wide), 0), columns)),
        int(min(max(np.ceil(right + wide), 0), columns)),
    )


@njit(error_model="numpy")
def _is_empty(drawn: Drawn, y: int, x: int, width: int) -> bool:
    """Return whether a pixel's samples and those above and beside it show the background."""
    rows, columns = drawn.piece.shape
    high, right = min(y + width, rows - FINE), min(x + width, columns - FINE)
    every = 0
    for up in range(FINE):
        for along in range(FINE):
            every |= drawn.piece[y + up, x + along]
            every |= drawn.piece[high + up, x + along] | drawn.piece[y + up, right + along]
    return not every


@njit(nogil=True, cache=True, error_model="numpy")
def blend(
    drawn: Drawn, colours: NDArray[np.float32], width: int, picture: NDArray[np.uint8]
) -> None:
    """Draw samples over a picture, with outlines.

    Args:
        drawn: the visible surfaces.
        colours: colours of each solid's shades, 0 to 255, (solids × `SHADES`, 3).
        width: width of outlines, samples.
        picture: red, green, blue and opacity, from the top row down, which are changed.
    """
    rows, columns = drawn.piece.shape
    for row in range(rows // FINE):
        line = picture[picture.shape[0] - 1 - drawn.bottom - row]
        for column in range(columns // FINE):
            if _is_empty(drawn, FINE * row, FINE * column, width):
                continue
            red, green, blue, count = np.float32(0), np.float32(0), np.float32(0), 0
            for y in range(FINE * row, FINE * row + FINE):
                for x in range(FINE * column, FINE * column + FINE):
                    paint, piece = drawn.paint[y, x], drawn.piece[y, x]
                    outline = paint
                    # The nearer of two pieces has the outline.
                    if y + width < rows and drawn.piece[y + width, x] != piece:
                        beyond = drawn.nearness[y + width, x] > drawn.nearness[y, x]
                        outline = drawn.paint[y + width, x] if beyond else paint
                        outline = outline // SHADES * SHADES
                    if x + width < columns and drawn.piece[y, x + width] != piece:
                        beyond = drawn.nearness[y, x + width] > drawn.nearness[y, x]
                        outline = drawn.paint[y, x + width] if beyond else paint
                        outline = outline // SHADES * SHADES
                    if outline:
                        red += colours[outline - SHADES, 0]
                        green += colours[outline - SHADES, 1]
                        blue += colours[outline - SHADES, 2]
                        count += 1
            if count:
                pixel, opacity = line[drawn.left + column], 255 * count // FINE**2
                for i, total in ((0, red), (1, green), (2, blue)):
                    own, under = int(total / count + np.float32(0.5)), 255 * int(pixel[i])
                    if count < FINE**2:  # as Matplotlib mixes colours
                        mixed = (256 * own - under) * opacity + 256 * under
                        own = mixed // (65280 + opacity)
                    pixel[i] = np.uint8(own)


@njit(nogil=True, cache=True, error_model="numpy")
def rule(
    picture: NDArray[np.uint8], ends: Floats, colours: NDArray[np.float32], width: float
) -> None:
    """Draw thin lines with smooth edges over a picture.

    A line covers each row, or each column if it is nearer to horizontal, from its first end up to
    but not including its last: lines that continue one another neither overlap nor leave a gap.

    Args:
        picture: red, green, blue and opacity, from the top row down, which are changed.
        ends: both ends of each line, pixels from the lower left corner, (lines, 2, 2).
        colours: red, green and blue of each line, 0 to 255, (lines, 3).
        width: width of the lines, pixels.
    """
    size = picture.shape[1], picture.shape[0]
    for line in range(len(ends)):
        run = ends[line, 1] - ends[line, 0]
        along = 0 if abs(run[0]) >= abs(run[1]) else 1
        aside = 1 - along
        length = abs(run[along])
        if length == 0:
            continue
        start, stop = ends[line, 0], ends[line, 1]
        if run[along] < 0:
            start, stop = stop, start
        slope = run[aside] / run[along]
        # Coverage falls from `most` to 0 across one pixel at each edge, measured along `aside`.
        slant = np.sqrt(1 + slope * slope)
        reach, most = (width + 1) / 2 * slant, min(width, 1.0)
        first = int(max(np.ceil(start[along] - 0.5), 0))
        last = int(min(np.ceil(stop[along] - 0.5), size[along]))
        for step in range(first, last):
            middle = start[aside] + (step + 0.5 - start[along]) * slope
            low = int(max(np.ceil(middle - reach - 0.5), 0))
            high = int(min(np.floor(middle + reach - 0.5) + 1, size[aside]))
            for place in range(low, high):
                cover = min((reach - abs(place + 0.5 - middle)) / slant, most)
                x, y = (step, place) if along == 0 else (place, step)
                pixel = picture[size[1] - 1 - y, x]
                for i in range(3):
                    pixel[i] = np.uint8(pixel[i] + (colours[line, i] - pixel[i]) * cover + 0.5)
