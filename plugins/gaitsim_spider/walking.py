"""Kinematic walking: resting plane, stance, margin, body twist, slip and path; compiled code.

Between two frames the servos move on a straight line, and contact is determined in the middle of
each frame interval. If it were determined at the frames, a body that flips between two poses every
frame would travel although no ground could push it forward.

Source of the support on slopes: R. B. McGhee, G. I. Iswandhi, Adaptive locomotion of a multilegged
robot over rough terrain, IEEE Transactions on Systems, Man, and Cybernetics 9 (1979) 176-182.
"""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import compiled, compiled_sin_and_cos as sin_and_cos
from gaitsim_spider.body import FOOT_RADIUS
from gaitsim_spider.damage import LegData
from gaitsim_spider.intervals import SIZE
from gaitsim_spider.kinematics import place_feet

_f = np.float32
_ZERO, _HALF, _ONE, _TWO = _f(0.0), _f(0.5), _f(1.0), _f(2.0)
_FAR = _f(1e9)


@compiled.inner
def find_feet(block: Any) -> None:
    """Find the three feet on which the body rests in each interval.

    Below the centre of mass, the lower hull is as high as the lowest triangle of feet
    (Carathéodory), so all 56 triangles are tried. If the centre is not above any
    triangle, no three feet support the body.
    """
    x, y, z, lowest, feet = block.x, block.y, block.z, block.height, block.feet
    for n in range(SIZE):
        lowest[n] = _FAR
        feet[n] = -1
    for i in range(6):
        for j in range(i + 1, 7):
            for k in range(j + 1, 8):
                code = np.int32(64 * i + 8 * j + k)
                for n in range(SIZE):
                    # Twice the areas of the triangles between two feet and the centre.
                    ij = x[i, n] * y[j, n] - y[i, n] * x[j, n]
                    jk = x[j, n] * y[k, n] - y[j, n] * x[k, n]
                    ki = x[k, n] * y[i, n] - y[k, n] * x[i, n]
                    height = (z[i, n] * jk + z[j, n] * ki + z[k, n] * ij) / (ij + jk + ki)
                    left = (ij >= _ZERO) & (jk >= _ZERO) & (ki >= _ZERO)
                    right = (ij <= _ZERO) & (jk <= _ZERO) & (ki <= _ZERO)
                    lower = (left | right) & (height < lowest[n])
                    lowest[n] = height if lower else lowest[n]
                    feet[n] = code if lower else feet[n]


@compiled.inner
def find_normal(block: Any, nx: Any, ny: Any, nz: Any, i: Any) -> Any:
    """Compute the upward unit normal n of the plane, and its height n·p for a foot p on it.

    A body that no three feet support tips over: its plane keeps the normal of the previous
    interval, and contains the first of the feet on which the body rested then. For the first
    interval, these are (nx, ny, nz) and `i`. Returns the last normal and foot.
    """
    x, y, z, feet = block.x, block.y, block.z, block.feet
    for n in range(SIZE):
        if feet[n] >= 0:
            i, j, k = feet[n] >> 6, (feet[n] >> 3) & 7, feet[n] & 7
            ux, uy, uz = x[j, n] - x[i, n], y[j, n] - y[i, n], z[j, n] - z[i, n]
            vx, vy, vz = x[k, n] - x[i, n], y[k, n] - y[i, n], z[k, n] - z[i, n]
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            scale = math.copysign(_ONE, nz) / math.sqrt(nx * nx + ny * ny + nz * nz)
            nx, ny, nz = nx * scale, ny * scale, nz * scale
        block.nx[n], block.ny[n], block.nz[n] = nx, ny, nz
        block.height[n] = nx * x[i, n] + ny * y[i, n] + nz * z[i, n]
    return nx, ny, nz, i


_ROUNDING = _f(1e-8)  # m²


@compiled.inner
def find_margin(block: Any) -> None:
    """Compute the distance of the centre of mass from the nearest side of the support polygon.

    Gift wrapping (Jarvis 1973) starts at the foot farthest from the centroid; no foot is to the
    right of the line to the next corner. Eight steps enclose any polygon of eight feet. Feet in the
    air are placed at the centroid, which is never a corner. Signed squares of distances are
    compared, so that only one root is needed.

    The margin is negative outside the polygon, and −1 m with fewer than three stance feet.
    """
    u, v, cu, cv, nearest = block.u, block.v, block.corner_u, block.corner_v, block.margin
    for n in range(SIZE):
        farthest = -_ONE
        for foot in range(8):
            square = u[foot, n] * u[foot, n] + v[foot, n] * v[foot, n]
            farther = square > farthest
            farthest = square if farther else farthest
            cu[n] = u[foot, n] if farther else cu[n]
            cv[n] = v[foot, n] if farther else cv[n]
        nearest[n] = _FAR
    for _ in range(8):
        for n in range(SIZE):
            du, dv = -cu[n], -cv[n]  # to the next corner; at first, to the centroid
            for foot in range(8):
                fu, fv = u[foot, n] - cu[n], v[foot, n] - cv[n]
                right = du * fv - dv * fu < -_ROUNDING
                du, dv = fu if right else du, fv if right else dv
            inside = du * (block.v0[n] - cv[n]) - dv * (block.u0[n] - cu[n])
            square = inside * abs(inside) / (du * du + dv * dv)
            nearest[n] = square if square < nearest[n] else nearest[n]
            cu[n] += du
            cv[n] += dv
    for n in range(SIZE):
        margin = math.copysign(math.sqrt(abs(nearest[n])), nearest[n])
        nearest[n] = margin if block.count[n] >= _f(3.0) else -_ONE


STANCE_TOLERANCE = 0.002  # m above the resting plane
_TOLERANCE = _f(STANCE_TOLERANCE)
# Abramowitz & Stegun 4.4.49.
_A3, _A5, _A7, _A9 = _f(-0.3333314528), _f(0.1999355085), _f(-0.1420889944), _f(0.1065626393)
_A11, _A13, _A15, _A17 = _f(-0.07528964), _f(0.0429096138), _f(-0.0161657367), _f(0.0028662257)


@njit(inline="always")
def _atan(x: Any) -> Any:
    """Return the arc tangent to 2e-8 for x from 0 to 1."""
    y = x * x
    tail = _A9 + y * (_A11 + y * (_A13 + y * (_A15 + y * _A17)))
    return x * (_ONE + y * (_A3 + y * (_A5 + y * (_A7 + y * tail))))


@compiled.inner
def _fill_axis(
    feet: Any, centre: Any, middle: Any, relative: Any, travelled: Any, first: int
) -> None:
    """Fill midpoints and travel along one axis; a loop over all axes would not vectorise."""
    body = centre[first : first + SIZE + 1]
    for n in range(SIZE):
        middle[n] = _HALF * (body[n] + body[n + 1])
    for leg in range(8):
        foot = feet[leg, first : first + SIZE + 1]
        for n in range(SIZE):
            relative[leg, n] = _HALF * (foot[n] + foot[n + 1]) - middle[n]
            travelled[leg, n] = foot[n + 1] - foot[n]


@njit(inline="always", error_model="numpy")
def _fill_block(block: Any, feet: Any, centre: Any, first: int) -> None:
    """Fill a block with midpoints and travel in the intervals from frame `first`."""
    _fill_axis(feet[0], centre[0], block.cx, block.x, block.dx, first)
    _fill_axis(feet[1], centre[1], block.cy, block.y, block.dy, first)
    _fill_axis(feet[2], centre[2], block.cz, block.z, block.dz, first)


@compiled.inner
def _project_feet(block: Any) -> None:
    """Find the feet on the resting plane; project all feet and their travel onto it.

    The shortest rotation of the normal n to the vertical maps a point p to
    p − n (p_z + (n_x p_x + n_y p_y) / (1 + n_z)) in the plane, at the height n·p.
    """
    x, y, z, dx, dy, dz = block.x, block.y, block.z, block.dx, block.dy, block.dz
    for n in range(SIZE):
        nx, ny, nz = block.nx[n], block.ny[n], block.nz[n]
        bend = _ONE / (_ONE + nz)
        block.slope[n] = _TWO * _atan(math.sqrt(nx * nx + ny * ny) * bend)
        for leg in range(8):
            lean = nx * x[leg, n] + ny * y[leg, n]
            on = lean + nz * z[leg, n] < block.height[n] + _TOLERANCE
            block.on[leg, n] = _ONE if on else _ZERO
            shift = z[leg, n] + lean * bend
            block.u[leg, n] = x[leg, n] - nx * shift
            block.v[leg, n] = y[leg, n] - ny * shift
            shift = dz[leg, n] + (nx * dx[leg, n] + ny * dy[leg, n]) * bend
            block.du[leg, n] = dx[leg, n] - nx * shift
            block.dv[leg, n] = dy[leg, n] - ny * shift


@compiled.inner
def _twist(block: Any) -> None:
    """Compute the slip, and the rigid motion of the body that best keeps stance feet in place.

    Uses least squares about the centroid of the stance feet. Without stance feet, the body does not
    move.
    """
    u, v, du, dv, on = block.u, block.v, block.du, block.dv, block.on
    for n in range(SIZE):
        count = mu = mv = mdu = mdv = _ZERO
        for leg in range(8):
            count += on[leg, n]
            mu += on[leg, n] * u[leg, n]
            mv += on[leg, n] * v[leg, n]
            mdu += on[leg, n] * du[leg, n]
            mdv += on[leg, n] * dv[leg, n]
        share = _ONE / (count if count > _ONE else _ONE)
        mu, mv, mdu, mdv = mu * share, mv * share, mdu * share, mdv * share
        turn = spread = _ZERO
        for leg in range(8):
            u[leg, n] = on[leg, n] * (u[leg, n] - mu)
            v[leg, n] = on[leg, n] * (v[leg, n] - mv)
            du[leg, n] = on[leg, n] * (du[leg, n] - mdu)
            dv[leg, n] = on[leg, n] * (dv[leg, n] - mdv)
            turn += v[leg, n] * du[leg, n] - u[leg, n] * dv[leg, n]
            spread += u[leg, n] * u[leg, n] + v[leg, n] * v[leg, n]
        turn = turn / spread if spread > _ZERO else _ZERO
        slid = _ZERO
        for leg in range(8):
            su, sv = du[leg, n] - turn * v[leg, n], dv[leg, n] + turn * u[leg, n]
            slid += math.sqrt(su * su + sv * sv)
        # The centre of mass on the plane, from the body's origin and from the centroid.
        nx, ny, nz = block.nx[n], block.ny[n], block.nz[n]
        shift = block.cz[n] + (nx * block.cx[n] + ny * block.cy[n]) / (_ONE + nz)
        block.count[n], block.u0[n], block.v0[n] = count, -mu, -mv
        block.forward[n] = turn * (mv + block.cy[n] - ny * shift) - mdu
        block.sideways[n] = -turn * (mu + block.cx[n] - nx * shift) - mdv
        block.turn[n], block.slip[n] = turn, slid * share


@njit(inline="always", error_model="numpy")
def _find_directions(block: Any) -> None:
    """Compute the cosines and sines of the headings."""
    for n in range(SIZE):
        block.ahead_y[n], block.ahead_x[n] = sin_and_cos(block.heading[n])


_RADIUS = _f(FOOT_RADIUS)


@compiled.inner
def _shear(block: Any, lean: Any) -> None:
    """Move the feet to where they appear along gravity, relative to the centre of mass.

    On a slope, the body rests on the feet around the point where the line of gravity through the
    centre of mass meets the ground (McGhee & Iswandhi 1979). After the shear, this line is
    vertical. The ground is a foot's radius below the centres of the feet.
    """
    for n in range(SIZE):
        block.lean_x[n] = lean[0] * block.ahead_x[n] + lean[1] * block.ahead_y[n]
        block.lean_y[n] = lean[1] * block.ahead_x[n] - lean[0] * block.ahead_y[n]
        for leg in range(8):
            depth = _RADIUS - block.z[leg, n]
            block.x[leg, n] -= depth * block.lean_x[n]
            block.y[leg, n] -= depth * block.lean_y[n]


@compiled.inner
def _project_centre(block: Any) -> None:
    """Project the centre of mass onto the plane along gravity instead of the plane's normal."""
    for n in range(SIZE):
        depth = _RADIUS - block.height[n]
        block.u0[n] += depth * block.lean_x[n]
        block.v0[n] += depth * block.lean_y[n]


@njit(nogil=True, cache=True, error_model="numpy")
def walk(
    angles: NDArray[np.float32],
    legs: LegData | None,
    lean: tuple[float, float] | None,
    feet: NDArray[np.float32],
    centre: NDArray[np.float32],
    blocks: NDArray[np.void],
    pose: NDArray[np.float32],
    stance: NDArray[np.bool_],
    slip: NDArray[np.float32],
    margin: NDArray[np.float32],
    slope: NDArray[np.float32],
) -> None:
    """Compute the motion of bodies over flat ground from their joint angles.

    Args:
        angles: joint angles from the pose at rest, (population, 24, frames) float32, radians, each
            within ±30°.
        legs: data of the legs, of one body or of each individual's; None if `feet` and `centre`
            hold the motion of one body.
        lean: components of gravity along the ground, forward and to the left of the initial
            heading, divided by the component into the ground. None on level ground, for which
            less is compiled.
        feet: working memory, (1, 3, 8, `whole_blocks(frames)`) float32; zeros at first. That of
            one individual, 80 kB for 300 frames, fits into the cache.
        centre: working memory, (1, 3, `whole_blocks(frames)`) float32; zeros at first.
        blocks: working memory, (1,) of dtype `BLOCK`; zeros at first.
        pose: output, (population, 3, frames) float32: x, y in metres and yaw in radians of the
            body in the world, starting from zero.
        stance: output, (population, 8, frames) bool: whether a foot is on the ground in the
            interval from this frame to the next; the last frame repeats the previous one.
        slip: output, (population, frames) float32, metres: mean slide of the stance feet in that
            interval.
        margin: output, (population, frames) float32, metres: static stability margin.
        slope: output, (population, frames) float32, radians: tilt of the resting plane.
    """
    block, last = blocks[0], angles.shape[2] - 1
    for individual in range(len(angles)):
        if legs is not None:
            own = min(individual, len(legs.lengths) - 1)
            one = LegData(
                legs.lengths[own : own + 1],
                legs.shares[own : own + 1],
                legs.hips[own : own + 1],
                legs.moments[own : own + 1],
            )
            place_feet(angles[individual : individual + 1], one, feet, centre)
        x = y = yaw = 0.0
        nx, ny, nz, foot = _ZERO, _ZERO, _ONE, np.int64(0)  # the type of later feet
        pose[individual, 0, 0] = pose[individual, 1, 0] = pose[individual, 2, 0] = _ZERO
        for first in range(0, last, SIZE):
            rest = last - first
            count = rest if rest < SIZE else SIZE
            before = yaw
            for n in range(SIZE):
                block.heading[n] = yaw
            # On a slope, the feet on which the body rests depend on its heading, and the heading on
            # these feet. The first pass takes the heading at the start of the block.
            for _ in range(1 if lean is None else 2):
                _fill_block(block, feet[0], centre[0], first)
                if lean is not None:
                    _find_directions(block)
                    _shear(block, lean)
                find_feet(block)
                if lean is not None:
                    _fill_block(block, feet[0], centre[0], first)
                normal = find_normal(block, nx, ny, nz, foot)
                _project_feet(block)
                _twist(block)
                yaw = before
                for n in range(count):
                    block.heading[n] = yaw + 0.5 * block.turn[n]
                    yaw += block.turn[n]
            nx, ny, nz, foot = normal
            if lean is not None:
                _project_centre(block)
            find_margin(block)
            _find_directions(block)
            yaw = before
            for n in range(count):
                x += block.forward[n] * block.ahead_x[n] - block.sideways[n] * block.ahead_y[n]
                y += block.forward[n] * block.ahead_y[n] + block.sideways[n] * block.ahead_x[n]
                yaw += block.turn[n]
                pose[individual, 0, first + n + 1] = x
                pose[individual, 1, first + n + 1] = y
                pose[individual, 2, first + n + 1] = yaw
                slip[individual, first + n] = block.slip[n]
                margin[individual, first + n] = block.margin[n]
                slope[individual, first + n] = block.slope[n]
            for leg in range(8):
                row = stance[individual, leg, first : first + count]  # a slice, as in `_fill_axis`
                for n in range(count):
                    row[n] = block.on[leg, n] > _ZERO
                stance[individual, leg, last] = row[count - 1]
        slip[individual, last] = slip[individual, last - 1]
        margin[individual, last] = margin[individual, last - 1]
        slope[individual, last] = slope[individual, last - 1]


# A body in a symmetric pose balances exactly on the line between two feet, where all triangles with
# this side are equally high. Beside the line, the lowest triangle has no foot below it.
_NUDGE = _f(1e-5)  # m


@njit(nogil=True, cache=True, error_model="numpy")
def rest(
    angles: NDArray[np.float32],
    legs: LegData,
    lean: tuple[float, float],
    heading: NDArray[np.float64],
    blocks: NDArray[np.void],
    normals: NDArray[np.float64],
) -> None:
    """Find the plane on which a body rests in each frame, as `walk` does between frames.

    Args:
        angles: joint angles from the pose at rest, (1, 24, frames) float32, radians.
        legs: data of the legs.
        lean: see `walk`.
        heading: yaw of the body in the world, (frames,), radians.
        blocks: working memory, (1,) of dtype `BLOCK`.
        normals: output, (frames, 3): upward unit normal in the body's frame.
    """
    frames = angles.shape[2]
    feet, centre = np.empty((1, 3, 8, frames), _f), np.empty((1, 3, frames), _f)
    place_feet(angles, legs, feet, centre)
    block, last = blocks[0], (_ZERO, _ZERO, _ONE, np.int64(0))
    for first in range(0, frames, SIZE):
        rest = frames - first
        count = rest if rest < SIZE else SIZE
        for n in range(count):
            for leg in range(8):
                block.x[leg, n] = feet[0, 0, leg, first + n] - centre[0, 0, first + n] - _NUDGE
                block.y[leg, n] = feet[0, 1, leg, first + n] - centre[0, 1, first + n] - _NUDGE
                block.z[leg, n] = feet[0, 2, leg, first + n] - centre[0, 2, first + n]
            block.heading[n] = heading[first + n]
        _find_directions(block)
        _shear(block, lean)
        find_feet(block)
        for n in range(count):  # undo the shear
            for leg in range(8):
                depth = _RADIUS - block.z[leg, n]
                block.x[leg, n] += depth * block.lean_x[n]
                block.y[leg, n] += depth * block.lean_y[n]
        last = find_normal(block, *last)
        for n in range(count):
            normals[first + n] = block.nx[n], block.ny[n], block.nz[n]
