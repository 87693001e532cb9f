"""The stability margin: how far the centre of mass is inside the support polygon; compiled."""

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

    From the foot that is farthest from the centroid, wrap a line around the stance feet: each
    next corner has no foot to the right of the way there (Jarvis 1973). Eight steps surround any
    polygon of them. Feet in the air count as the centroid, which is never a corner. Distances are
    compared by their signed squares, which takes one root in all.

    Negative outside the polygon; −1 m where fewer than three feet stand.
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
            nearest[n] = min(nearest[n], inside * abs(inside) / (du * du + dv * dv))
            cu[n] += du
            cv[n] += dv
    for n in range(SIZE):
        margin = math.copysign(math.sqrt(abs(nearest[n])), nearest[n])
        nearest[n] = margin if block.count[n] >= _f(3.0) else -_ONE
