"""Annotations on a picture of a body: a scale bar, an altitude axis and the heading."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.gait.feet import Floats
from gaitsim.gait.travel import heading, trunk
from gaitsim.render.scene.camera import Camera
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.terminal.braille import HIGH, SPACE, WIDE, Inks, cells, empty
from gaitsim.render.terminal.text import number
from gaitsim.render.ticks import UNITS, format_round_length, labels, round_step

MIN_SIZE = 24, 6  # minimum columns and rows of a picture with annotations
MIN_BAR = 6  # minimum columns of a scale bar
MIN_LENGTH = 1e-5  # metres; every body is larger
MIN_TICK_GAP = 3  # minimum rows between two ticks of altitude
STEEP = 0.9  # sine of the camera's elevation above which altitude is not visible
ARROWS = "↑↖←↙↓↘→↗"  # headings seen from above, with the initial heading up

Codes = NDArray[np.uint32]


def annotate(
    codes: Codes, inks: Inks, ink: int, eye: Camera, clip: Clip, pose: Pose, turned: float | None
) -> None:
    """Write the scale, the heading and a flying body's altitude onto a picture.

    Args:
        codes: characters of the picture, (rows, columns), modified in place.
        inks: inks of the picture, (rows, columns), modified in place.
        ink: ink of the annotations.
        eye: the camera, in dots.
        clip: the body in motion.
        pose: current pose of the body.
        turned: turn to the left since the start, radians; None for a body without a heading.
    """
    rows, columns = codes.shape
    if columns < MIN_SIZE[0] or rows < MIN_SIZE[1]:
        return

    def write(row: int, column: int, signs: list[int]) -> None:
        end = min(column + len(signs), columns)
        codes[row, column:end] = signs[: end - column]
        inks[row, column:end] = ink

    texts = []
    if clip.flies:
        texts.append(f"altitude {number(pose.middle[2] + clip.floor, 2)} m")
        if abs(float(eye.ahead[2])) < STEEP:
            for row, word in _altitudes(eye, clip, pose, rows - 1):
                write(row, 0, _signs(word))
    if turned is not None:
        texts.append(format_yaw(turned))
    bar = _bar(eye, columns // 2)
    write(rows - 1, 0, [*bar, SPACE] if bar else bar)
    word = " " + "  ".join(texts)
    if texts and len(bar) + 1 + len(word) <= columns:
        write(rows - 1, columns - len(word), _signs(word))


def format_yaw(turned: float) -> str:
    """Format a turn to the left, radians, such as 'yaw ↖ 40°'."""
    arrow = ARROWS[round(turned / (np.pi / 4)) % len(ARROWS)]
    return f"yaw {arrow} {np.degrees(turned):z.0f}°".replace("-", "−")


@lru_cache(8)
def headings(skeleton: Skeleton) -> Floats | None:
    """Return the turn of a body's trunk to the left since the start, (frames,), radians."""
    return heading(trunk(skeleton))


def _bar(eye: Camera, widest: int) -> list[int]:
    """Return a bar of a round length at the camera's target, followed by that length.

    The result is empty for a body without extent, whose scale has no meaning.
    """
    if MIN_BAR * WIDE / eye.scale < MIN_LENGTH:
        return []
    metres = round_step(MIN_BAR * WIDE / eye.scale)
    width = round(metres * eye.scale)  # dots
    if width > widest * WIDE:
        return []
    dots = empty(width // WIDE + 1, 1)
    dots[2, : width + 1] = 1
    dots[1:, [0, width]] = 1
    return [*cells(dots)[0][0].tolist(), *_signs(" " + format_round_length(metres))]


def _altitudes(eye: Camera, clip: Clip, pose: Pose, rows: int) -> list[tuple[int, str]]:
    """Return the rows and labels of an altitude axis, with a mark at the body's altitude."""
    place, height = pose.middle, int(2 * eye.centre[1]) + 1
    scale = float(eye.scale_at(eye.project(place)[1])) * max(float(eye.up[2]), 0.1)
    step = round_step(MIN_TICK_GAP * HIGH / scale)
    own = float(place[2]) + clip.floor
    count = int(rows * HIGH / scale / step) + 1
    at = (np.arange(-count, count + 1) + round(own / step)) * step
    at = at[at >= clip.floor - step / 2]  # no ticks below the ground
    points = np.tile(place, (len(at) + 1, 1))
    points[1:, 2] = at - clip.floor
    mark, *below = ((height - 1 - eye.project(points)[0][:, 1]) // HIGH).astype(int).tolist()
    seen = {row: value for row, value in zip(below, at.tolist(), strict=True) if 0 < row < rows}
    if not seen:
        return []
    size, unit = next((one for one in UNITS if step >= one[0] * 0.999), UNITS[-1])
    words = labels(np.array([*seen.values()]) / size)
    wide = max(map(len, words))
    found = {row: word.rjust(wide) + "┤" for row, word in zip(seen, words, strict=True)}
    if 0 < mark < rows:
        found[mark] = " " * wide + "▸"
    return [(0, unit.rjust(wide)), *found.items()]


def _signs(word: str) -> list[int]:
    return [ord(sign) for sign in word]
