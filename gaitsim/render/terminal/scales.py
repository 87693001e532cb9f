"""Annotations on a picture of a body: a scale bar, the altitude and the heading."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.gait.feet import Floats
from gaitsim.gait.travel import heading, trunk
from gaitsim.render.scene.camera import Camera
from gaitsim.render.scene.clip import Clip, Pose
from gaitsim.render.terminal.braille import WIDE, Inks, Paper, cells, empty
from gaitsim.render.terminal.text import number
from gaitsim.render.ticks import format_round_length, round_step

MIN_SIZE = 24, 6  # minimum columns and rows of a picture with annotations
MIN_BAR = 6  # minimum columns of a scale bar
MIN_LENGTH = 1e-5  # metres; every body is larger
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

    paper = Paper(codes, inks)
    texts = []
    if clip.flies:
        texts.append(f"altitude {number(pose.middle[2] + clip.floor, 2)} m")
    if turned is not None:
        texts.append(format_yaw(turned))
    bar = _bar(eye, columns // 2)
    paper.write(rows - 1, 0, f"{bar} " if bar else "", ink)
    word = " " + "  ".join(texts)
    if texts and len(bar) + 1 + len(word) <= columns:
        paper.write(rows - 1, columns - len(word), word, ink)


def format_yaw(turned: float) -> str:
    """Format a turn to the left, radians, such as 'yaw ↖ 40°'."""
    arrow = ARROWS[round(turned / (np.pi / 4)) % len(ARROWS)]
    return f"yaw {arrow} {np.degrees(turned):z.0f}°".replace("-", "−")


@lru_cache(8)
def headings(skeleton: Skeleton) -> Floats | None:
    """Return the turn of a body's trunk to the left since the start, (frames,), radians."""
    return heading(trunk(skeleton))


def _bar(eye: Camera, widest: int) -> str:
    """Return a bar of a round length at the camera's target, followed by that length.

    The result is empty for a body without extent, whose scale has no meaning.
    """
    if MIN_BAR * WIDE / eye.scale < MIN_LENGTH:
        return ""
    metres = round_step(MIN_BAR * WIDE / eye.scale)
    width = round(metres * eye.scale)  # dots
    if width > widest * WIDE:
        return ""
    dots = empty(width // WIDE + 1, 1)
    dots[2, : width + 1] = 1
    dots[1:, [0, width]] = 1
    return "".join(map(chr, cells(dots)[0][0])) + f" {format_round_length(metres)}"
