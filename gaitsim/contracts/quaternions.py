"""Rotations as unit quaternions (w, x, y, z)."""

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import cos, sin

Floats = NDArray[np.float64]


def cross(one: Floats, other: Floats) -> Floats:
    """Return cross products (…, 3); for few vectors four times as fast as NumPy's."""
    a, b, c = one[..., 0], one[..., 1], one[..., 2]
    x, y, z = other[..., 0], other[..., 1], other[..., 2]
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)


def conjugate(turns: Floats) -> Floats:
    """Return the inverse rotations of quaternions (…, 4)."""
    return np.asarray(turns * (1.0, -1.0, -1.0, -1.0))


def rotated(turns: Floats, points: Floats) -> Floats:
    """Rotate points (…, 3) by quaternions (…, 4)."""
    axis = turns[..., 1:]
    twice = 2 * cross(axis, points)
    return np.asarray(points + turns[..., :1] * twice + cross(axis, twice))


def product(one: Floats, other: Floats) -> Floats:
    """Return the products of quaternions (…, 4): the rotation `other`, followed by `one`."""
    scalar, axis = one[..., :1], one[..., 1:]
    second, along = other[..., :1], other[..., 1:]
    real = scalar * second - (axis * along).sum(axis=-1, keepdims=True)
    return np.concatenate([real, scalar * along + second * axis + cross(axis, along)], axis=-1)


def turn_about(axis: Floats, angles: Floats) -> Floats:
    """Return quaternions (…, 4) of rotations about a unit axis (3,) by angles (…,), rad."""
    half = np.asarray(angles)[..., None] / 2
    return np.concatenate([cos(half), sin(half) * axis], axis=-1)


def turn_about_axis(axis: int, angle: float) -> tuple[float, float, float, float]:
    """Return the rotation by an angle in radians about the x (0), y (1) or z (2) axis.

    The result is a tuple, as `Link.rotation` requires.
    """
    turn = [float(cos(angle / 2)), 0.0, 0.0, 0.0]
    turn[1 + axis] = float(sin(angle / 2))
    w, x, y, z = turn
    return w, x, y, z
