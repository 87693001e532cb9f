"""The stability margin: distance of the centre of mass from the support's edge; compiled code."""

import math
from typing import Any

import numpy as np
from numba import njit

from gaitsim_spider.intervals import SIZE

_f = np.float32
_ONE, _FAR = _f(1.0), _f(1e9)
_ROUNDING = _f(1e-8)  # m²


@njit(error_model="numpy")
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
