"""Walking, kinematically: resting plane, stance, body twist, slip, stability; compiled.

Between two frames the servos move on a straight line, so contact is determined in the middle
of each frame interval. Determined at the frames, a body that flips between two poses every
frame would earn travel that no ground could give it.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

_f = np.float32
_ZERO, _HALF, _ONE = _f(0.0), _f(0.5), _f(1.0)
_FAR = _f(1e9)
STANCE_TOLERANCE = 0.002  # m above the resting plane
_TOLERANCE = _f(STANCE_TOLERANCE)
_ROUNDING = _f(1e-6)  # m


@njit(inline="always")
def _normal(points: Any, i: int, j: int, k: int) -> Any:
    """Upward unit normal of the plane through three points."""
    ux, uy, uz = (
        points[j, 0] - points[i, 0],
        points[j, 1] - points[i, 1],
        points[j, 2] - points[i, 2],
    )
    vx, vy, vz = (
        points[k, 0] - points[i, 0],
        points[k, 1] - points[i, 1],
        points[k, 2] - points[i, 2],
    )
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    scale = math.copysign(_ONE, nz) / math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx * scale, ny * scale, nz * scale


@njit(inline="always")
def _still_rests(feet: Any, centre: Any, i: int, j: int, k: int) -> Any:
    """Whether the body rests on these three feet: centre above them, no foot below them."""
    xi, yi = feet[i, 0] - centre[0], feet[i, 1] - centre[1]
    xj, yj = feet[j, 0] - centre[0], feet[j, 1] - centre[1]
    xk, yk = feet[k, 0] - centre[0], feet[k, 1] - centre[1]
    ij, jk, ki = xi * yj - yi * xj, xj * yk - yj * xk, xk * yi - yk * xi
    if not (
        (ij > _ZERO and jk > _ZERO and ki > _ZERO) or (ij < _ZERO and jk < _ZERO and ki < _ZERO)
    ):
        return False
    nx, ny, nz = _normal(feet, i, j, k)
    lowest = _ZERO
    for foot in range(8):
        height = (
            nx * (feet[foot, 0] - feet[i, 0])
            + ny * (feet[foot, 1] - feet[i, 1])
            + nz * (feet[foot, 2] - feet[i, 2])
        )
        lowest = min(lowest, height)
    return lowest > -_ROUNDING


@njit(inline="always")
def _rest(feet: Any, centre: Any) -> Any:
    """The three feet that the body rests on: the lower hull of the feet under its centre.

    The lower hull's height there is the lowest that any triangle of feet reaches under
    the centre of mass (Carathéodory), so all 56 triangles are tried.
    Returns their indices, or −1 where no triangle has the centre above it.
    """
    lowest = _FAR
    a = b = c = -1
    for i in range(6):
        xi, yi = feet[i, 0] - centre[0], feet[i, 1] - centre[1]
        for j in range(i + 1, 7):
            xj, yj = feet[j, 0] - centre[0], feet[j, 1] - centre[1]
            ij = xi * yj - yi * xj
            for k in range(j + 1, 8):
                xk, yk = feet[k, 0] - centre[0], feet[k, 1] - centre[1]
                jk, ki = xj * yk - yj * xk, xk * yi - yk * xi
                if (ij >= _ZERO and jk >= _ZERO and ki >= _ZERO) or (
                    ij <= _ZERO and jk <= _ZERO and ki <= _ZERO
                ):
                    area = ij + jk + ki
                    if area != _ZERO:
                        height = (feet[i, 2] * jk + feet[j, 2] * ki + feet[k, 2] * ij) / area
                        if height < lowest:
                            lowest = height
                            a, b, c = i, j, k
    return a, b, c


@njit(inline="always")
def _tilt(plane: Any, nx: Any, ny: Any, nz: Any) -> None:
    """Fill `plane` with the shortest rotation that takes a unit normal to the vertical."""
    bend = _ONE / (_ONE + nz)
    plane[0, 0], plane[0, 1], plane[0, 2] = _ONE - nx * nx * bend, -nx * ny * bend, -nx
    plane[1, 0], plane[1, 1], plane[1, 2] = -nx * ny * bend, _ONE - ny * ny * bend, -ny
    plane[2, 0], plane[2, 1], plane[2, 2] = nx, ny, nz


@njit(inline="always")
def _margin(points: Any, count: int, plane: Any, centre: Any) -> Any:
    """Distance of the centre, projected on the plane, from the nearest edge of the hull.

    Negative outside the hull; −1 m where fewer than three points have no hull.
    """
    x = plane[0, 0] * centre[0] + plane[0, 1] * centre[1] + plane[0, 2] * centre[2]
    y = plane[1, 0] * centre[0] + plane[1, 1] * centre[1] + plane[1, 2] * centre[2]
    margin = _FAR
    for i in range(count):
        for j in range(count):
            ex, ey = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = ex * ex + ey * ey
            if length > _ZERO:
                is_edge = True
                for k in range(count):
                    side = ex * (points[k, 1] - points[i, 1]) - ey * (points[k, 0] - points[i, 0])
                    if k not in (i, j) and side < _ZERO:
                        is_edge = False
                        break
                if is_edge:
                    off = ex * (y - points[i, 1]) - ey * (x - points[i, 0])
                    margin = min(margin, off / math.sqrt(length))
    return margin if count > 2 else -_ONE


@njit(inline="always")
def _twist(flat: Any, step: Any, count: int) -> Any:
    """Return the rigid motion that best keeps the stance feet in place.

    Least squares about their centroid, for feet at `flat` that travel by `step` in the
    body's frame. Returns forward and sideways travel of the body, its turn, and the mean
    distance that the feet still slide. Without feet on the ground nothing moves.
    """
    share = _ONE / _f(max(count, 1))
    px = py = dx = dy = _ZERO
    for n in range(count):
        px += flat[n, 0] * share
        py += flat[n, 1] * share
        dx += step[n, 0] * share
        dy += step[n, 1] * share
    turn = spread = _ZERO
    for n in range(count):
        rx, ry = flat[n, 0] - px, flat[n, 1] - py
        turn -= rx * (step[n, 1] - dy) - ry * (step[n, 0] - dx)
        spread += rx * rx + ry * ry
    turn = turn / spread if spread > _ZERO else _ZERO
    forward, sideways = turn * py - dx, -turn * px - dy
    slid = _ZERO
    for n in range(count):
        sx = step[n, 0] + forward - turn * flat[n, 1]
        sy = step[n, 1] + sideways + turn * flat[n, 0]
        slid += math.sqrt(sx * sx + sy * sy)
    return forward, sideways, turn, slid * share


@njit(inline="always")
def _put_down(
    feet: Any, middle: Any, plane: Any, origin: int, stance: Any, flat: Any, step: Any
) -> Any:
    """Find the feet on the resting plane; project them and their travel onto it.

    Args:
        feet: (3, 8, 2), this frame's and the next one's.
        middle: (8, 3), half-way between.
        plane: rows of the rotation that takes the plane's normal to the vertical.
        origin: a foot on the plane.
        stance: filled, (8,) bool.
        flat: filled, (count, 2).
        step: filled, (count, 2).

    Returns:
        count, the number of feet on the plane.
    """
    count = 0
    for leg in range(8):
        height = _ZERO
        for axis in range(3):
            height += plane[2, axis] * (middle[leg, axis] - middle[origin, axis])
        stance[leg] = height < _TOLERANCE
        if stance[leg]:
            for row in range(2):
                place = travel = _ZERO
                for axis in range(3):
                    place += plane[row, axis] * middle[leg, axis]
                    travel += plane[row, axis] * (feet[axis, leg, 1] - feet[axis, leg, 0])
                flat[count, row] = place
                step[count, row] = travel
            count += 1
    return count


@njit(nogil=True, cache=True, error_model="numpy")
def walk(
    feet: NDArray[np.float32],
    centre: NDArray[np.float32],
    pose: NDArray[np.float32],
    stance: NDArray[np.bool_],
    slip: NDArray[np.float32],
    margin: NDArray[np.float32],
    slope: NDArray[np.float32],
) -> None:
    """Compute how feet that move in the body's frame move the body over flat ground.

    Args:
        feet: (population, 3, 8, frames) float32, metres, body's frame.
        centre: (population, 3, frames) float32, metres: centre of mass, body's frame.
        pose: filled, (population, frames, 3) float32: x, y in metres and yaw in radians
            of the body in the world, starting from zero.
        stance: filled, (population, frames, 8) bool: feet on the ground in the interval
            from this frame to the next; the last frame repeats the one before.
        slip: filled, (population, frames) float32, metres: mean distance that the feet in
            stance slid in that interval.
        margin: filled, likewise, metres: static stability margin.
        slope: filled, likewise, radians: tilt of the resting plane.
    """
    last = feet.shape[3] - 1
    middle, balance = np.empty((8, 3), dtype=_f), np.empty(3, dtype=_f)
    plane = np.empty((3, 3), dtype=_f)
    flat, step = np.empty((8, 2), dtype=_f), np.empty((8, 2), dtype=_f)
    for individual in range(feet.shape[0]):
        x = y = yaw = 0.0
        i = j = k = -1
        origin = 0
        _tilt(plane, _ZERO, _ZERO, _ONE)
        pose[individual, 0, :] = _ZERO
        for frame in range(last):
            ends = feet[individual, :, :, frame : frame + 2]
            for axis in range(3):
                for leg in range(8):
                    middle[leg, axis] = _HALF * (ends[axis, leg, 0] + ends[axis, leg, 1])
                balance[axis] = _HALF * (
                    centre[individual, axis, frame] + centre[individual, axis, frame + 1]
                )
            # The body usually rests on the same feet as before: a tenth of the search's work.
            if i < 0 or not _still_rests(middle, balance, i, j, k):
                i, j, k = _rest(middle, balance)
            if i >= 0:  # else: it tips over and keeps the last plane
                nx, ny, nz = _normal(middle, i, j, k)
                _tilt(plane, nx, ny, nz)
                origin = i
            count = _put_down(ends, middle, plane, origin, stance[individual, frame], flat, step)
            forward, sideways, turn, slid = _twist(flat, step, count)
            slip[individual, frame] = slid
            slope[individual, frame] = math.acos(min(plane[2, 2], _ONE))
            margin[individual, frame] = _margin(flat, count, plane, balance)
            heading = yaw + 0.5 * turn
            x += forward * math.cos(heading) - sideways * math.sin(heading)
            y += forward * math.sin(heading) + sideways * math.cos(heading)
            yaw += turn
            pose[individual, frame + 1, 0] = x
            pose[individual, frame + 1, 1] = y
            pose[individual, frame + 1, 2] = yaw
        stance[individual, last] = stance[individual, last - 1]
        slip[individual, last] = slip[individual, last - 1]
        margin[individual, last] = margin[individual, last - 1]
        slope[individual, last] = slope[individual, last - 1]
