"""The ground: a grid that fades with distance and becomes coarser with altitude."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.scene.camera import Camera, Points

SHADES = 8  # steps in which lines fade
PIECES = 20  # pieces of a line
SPARSE, DENSE = 420.0, 34.0  # pixels between lines at which they have full strength, and vanish
MAX_LINES = 80  # maximum number of lines in each direction
_LADDER = (1.0, 5.0)  # times powers of ten, metres: each step is a multiple of the previous one


def steps(spacing: float) -> list[float]:
    """Return four distances between lines, starting with the smallest of at least `spacing`."""
    power = int(np.floor(np.log10(spacing))) - 1
    every = [factor * 10.0**p for p in range(power, power + 6) for factor in _LADDER]
    return [step for step in every if step >= spacing * 0.999][:4]


def fine_step(scale: float, unit: float) -> float:
    """Return the distance between the finest lines visible at a scale, metres."""
    return steps(1.5 * DENSE * unit / scale)[0]


def grid(
    camera: Camera, span: float, reach: float, unit: float, corners: tuple[Points, Points]
) -> tuple[Points, NDArray[np.float64]]:
    """Return the pieces of the grid's lines around the aim of the camera.

    Args:
        camera: camera of the picture.
        span: largest extent of the body, m.
        reach: radius of the drawn ground, pixels at its distance.
        unit: size of the picture; see `relative_size`.
        corners: x and y of the corners of the ground, where lines must bend, (corners,) m each.

    Returns:
        Both ends of each piece, at z = 0, (pieces, 2, 3) m, and its strength, 0 to 1, (pieces,).
    """
    middle = _aim(camera, span)
    _, depth = camera.project(middle)
    scale = float(camera.scale_at(depth))
    radius = reach / scale
    pieces, strengths = [], []
    every = steps(DENSE * unit / scale)
    for step, coarser in zip(every, [*every[1:], 0.0], strict=True):
        strength = np.log(step * scale / unit / DENSE) / np.log(SPARSE / DENSE)
        lines = int(min(radius / step, MAX_LINES))
        for axis in (0, 1):
            across = (np.round(middle[axis] / step) + np.arange(-lines, lines + 1)) * step
            if coarser:  # leave out the lines that the coarser grid draws
                across = across[np.abs(across / coarser - np.round(across / coarser)) > 1e-6]
            along = middle[1 - axis] + np.linspace(-radius, radius, PIECES + 1)
            bends = corners[1 - axis]
            along = np.union1d(along, bends[(along[0] < bends) & (bends < along[-1])])
            points = np.zeros((len(across), len(along), 3))
            points[:, :, axis] = across[:, None]
            points[:, :, 1 - axis] = along
            pieces.append(np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3))
            strengths.append(np.full(len(pieces[-1]), min(strength, 1.0)))
    ends, strength = np.concatenate(pieces), np.concatenate(strengths)
    away = np.linalg.norm(ends.mean(axis=1) - middle, axis=1) / radius
    return ends, strength * np.clip(1 - away**2, 0, 1) ** 1.5


def _aim(camera: Camera, span: float) -> Points:
    """Return the middle of the ground: below a body, or in the view of one that flies high."""
    foot = np.array([camera.target[0], camera.target[1], 0.0])
    above, down = max(float(camera.target[2]) - span, 0.0), -float(camera.ahead[2])
    if down > 0:
        foot[:2] += camera.ahead[:2] * min(above / down, 4 * camera.distance)
    return foot
