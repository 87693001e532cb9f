"""A steered body in a terminal: a camera that follows the body, and a plan of its path."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.scene.camera import DISTANCE, Camera, Points, axes
from gaitsim.render.terminal.braille import HIGH, WIDE, Inks, Paper, cells, draw_lines, empty
from gaitsim.render.terminal.scales import ARROWS
from gaitsim.render.ticks import format_round_length, round_step

VIEWS = {"behind": (180.0, 18.0), "side": (-90.0, 7.0), "above": (180.0, 89.0)}
"""Azimuth from the body's heading and elevation of the camera, degrees."""

BODY_HEIGHT = 0.6  # height of the body in a picture, as a share
MIN_HEIGHT, MAX_HEIGHT = 2.5, 6.0  # height of a picture in body lengths
GROUND_ROOM = 1.25  # height of the part below the body, in its altitudes: keeps the ground in view
PATH, BODY, SCALE = 1, 2, 3  # inks of a plan
MIN_MARGIN = 1.5  # minimum margin of a plan on every side, in body lengths


def chase_camera(
    view: str, turned: float, place: Points, size: float, zoom: float, columns: int, rows: int
) -> Camera:
    """Return a camera that keeps the ground below a body in the picture, up to some altitude.

    Args:
        view: name of a view in `VIEWS`.
        turned: heading that the camera follows, radians to the left of x.
        place: position of the body above the ground, (3,) m.
        size: length of the body, m.
        zoom: magnification; 1 for the usual distance.
        columns: width of the picture.
        rows: height of the picture.
    """
    azimuth, elevation = VIEWS[view]
    right, up, ahead = axes(azimuth + float(np.degrees(turned)), elevation)
    width, height = columns * WIDE, rows * HIGH
    tall = float(
        np.clip(GROUND_ROOM * place[2] / BODY_HEIGHT, MIN_HEIGHT * size, MAX_HEIGHT * size)
    )
    scale = zoom * min(height / tall, width / (MIN_HEIGHT * size))
    return Camera(
        np.asarray(place, dtype=np.float64),
        *(right, up, ahead),
        distance=DISTANCE * max(size, tall / 2),
        scale=scale,
        centre=np.array([(width - 1) / 2, BODY_HEIGHT * (height - 1)]),
    )


def draw_path(
    path: Points, turned: float, size: float, columns: int, rows: int
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw a path from above, with the initial heading up: code points and inks, (rows, columns).

    Args:
        path: (places, 3) m, with the body's current position last.
        turned: turn of the body to the left since the start, radians.
        size: length of the body, m.
        columns: width of the picture.
        rows: height of the picture.
    """
    dots = empty(columns, rows)
    if not dots.size:
        return cells(dots)
    flat = np.stack([-path[:, 1], -path[:, 0]], axis=1)  # right, down
    low, high = flat.min(axis=0), flat.max(axis=0)
    room = np.array([columns * WIDE - 1.0, rows * HIGH - 1.0])
    scale = float((room / (np.maximum(high - low, 0) + 2 * MIN_MARGIN * size)).min())
    at = (flat - (low + high) / 2) * scale + room / 2
    draw_lines(dots, np.stack([at[:-1], at[1:]], axis=1), np.full(len(at) - 1, PATH))
    codes, inks = cells(dots)
    row, column = int(at[-1, 1]) // HIGH, int(at[-1, 0]) // WIDE
    codes[row, column] = ord(ARROWS[round(turned / (np.pi / 4)) % len(ARROWS)])
    inks[row, column] = BODY
    step = round_step(columns / 4 * WIDE / scale)
    words = f"{'─' * max(int(step * scale / WIDE), 1)} {format_round_length(step)}"
    if len(words) <= columns:
        Paper(codes, inks).write(-1, 0, words, SCALE)
    return codes, inks
