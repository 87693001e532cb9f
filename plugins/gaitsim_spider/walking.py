"""Walking, kinematically: resting plane, stance, body twist, slip, stability; compiled.

Between two frames the servos move on a straight line, so contact is judged in the middle
of each frame interval. Judged at the frames, a body that flips between two poses every
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


@njit(inline="always")
def _rest(feet: Any, centre: Any, cross: Any) -> Any:
    """The three feet that the body rests on: the lower hull of the feet under its centre.

    The lower hull's height there is the lowest that any triangle of feet reaches under
    the centre of mass (Carathéodory), so the 56 triangles are simply tried.
    Returns their indices, or −1 where no triangle has the centre above it.
    """
    for i in range(8):
        xi, yi = feet[i, 0] - centre[0], feet[i, 1] - centre[1]
        for j in range(i + 1, 8):
            cross[i, j] = xi * (feet[j, 1] - centre[1]) - yi * (feet[j, 0] - centre[0])
    lowest = _FAR
    a = b = c = -1
    for i in range(6):
        for j in range(i + 1, 7):
            ij = cross[i, j]
            for k in range(j + 1, 8):
                jk, ki = cross[j, k], -cross[i, k]
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
def _margin(points: Any, count: int, x: Any, y: Any) -> Any:
    """Distance from (x, y) to the nearest edge of the hull of points, negative outside."""
    margin = _FAR
    for i in range(count):
        for j in range(count):
            ex, ey = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            length = ex * ex + ey * ey
            if i != j and length > _ZERO:
                edge = True
                for k in range(count):
                    side = ex * (points[k, 1] - points[i, 1]) - ey * (points[k, 0] - points[i, 0])
                    # Points on the edge itself do not spoil it.
                    if k not in (i, j) and side < _ZERO:
                        edge = False
                        break
                if edge:
                    distance = (ex * (y - points[i, 1]) - ey * (x - points[i, 0])) / math.sqrt(
                        length
                    )
                    margin = min(margin, distance)
    return margin


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
    """How feet that move in the body's frame move the body over flat ground.

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
    frames = feet.shape[3]
    middle = np.empty((8, 3), dtype=_f)
    balance = np.empty(3, dtype=_f)
    cross = np.empty((8, 8), dtype=_f)
    flat = np.empty((8, 2), dtype=_f)  # stance feet on the resting plane
    step = np.empty((8, 2), dtype=_f)  # their travel in the interval
    for individual in range(feet.shape[0]):
        x = y = yaw = 0.0
        nx, ny, nz = _ZERO, _ZERO, _ONE
        a = 0
        pose[individual, 0, :] = _ZERO
        for frame in range(frames - 1):
            for leg in range(8):
                for axis in range(3):
                    middle[leg, axis] = _HALF * (
                        feet[individual, axis, leg, frame] + feet[individual, axis, leg, frame + 1]
                    )
            for axis in range(3):
                balance[axis] = _HALF * (
                    centre[individual, axis, frame] + centre[individual, axis, frame + 1]
                )
            i, j, k = _rest(middle, balance, cross)
            if i >= 0:  # else: it tips over, and the last plane stands
                nx, ny, nz = _normal(middle, i, j, k)
                a = i
            # The rotation that takes the plane's normal to the vertical, two rows of it.
            bend = _ONE / (_ONE + nz)
            xx, xy, xz = _ONE - nx * nx * bend, -nx * ny * bend, -nx
            yx, yy, yz = xy, _ONE - ny * ny * bend, -ny

            count = 0
            px = py = dx = dy = _ZERO
            for leg in range(8):
                height = (
                    nx * (middle[leg, 0] - middle[a, 0])
                    + ny * (middle[leg, 1] - middle[a, 1])
                    + nz * (middle[leg, 2] - middle[a, 2])
                )
                on_ground = height < _TOLERANCE
                stance[individual, frame, leg] = on_ground
                if on_ground:
                    qx, qy, qz = middle[leg, 0], middle[leg, 1], middle[leg, 2]
                    flat[count, 0] = xx * qx + xy * qy + xz * qz
                    flat[count, 1] = yx * qx + yy * qy + yz * qz
                    tx = feet[individual, 0, leg, frame + 1] - feet[individual, 0, leg, frame]
                    ty = feet[individual, 1, leg, frame + 1] - feet[individual, 1, leg, frame]
                    tz = feet[individual, 2, leg, frame + 1] - feet[individual, 2, leg, frame]
                    step[count, 0] = xx * tx + xy * ty + xz * tz
                    step[count, 1] = yx * tx + yy * ty + yz * tz
                    px += flat[count, 0]
                    py += flat[count, 1]
                    dx += step[count, 0]
                    dy += step[count, 1]
                    count += 1
            share = _ONE / _f(max(count, 1))
            px, py, dx, dy = px * share, py * share, dx * share, dy * share

            # The rigid motion of the body that leaves the stance feet most nearly where
            # they are: least squares about their centroid.
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
            slip[individual, frame] = slid * share
            slope[individual, frame] = math.acos(min(nz, _ONE))
            margin[individual, frame] = _margin(
                flat,
                count,
                xx * balance[0] + xy * balance[1] + xz * balance[2],
                yx * balance[0] + yy * balance[1] + yz * balance[2],
            )
            heading = yaw + 0.5 * turn
            x += forward * math.cos(heading) - sideways * math.sin(heading)
            y += forward * math.sin(heading) + sideways * math.cos(heading)
            yaw += turn
            pose[individual, frame + 1, 0] = x
            pose[individual, frame + 1, 1] = y
            pose[individual, frame + 1, 2] = yaw
        stance[individual, frames - 1] = stance[individual, frames - 2]
        slip[individual, frames - 1] = slip[individual, frames - 2]
        margin[individual, frames - 1] = margin[individual, frames - 2]
        slope[individual, frames - 1] = slope[individual, frames - 2]
