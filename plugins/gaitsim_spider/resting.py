"""The resting plane, the lower hull of the feet below the centre of mass; compiled code."""

import math
from typing import Any

import numpy as np
from numba import njit

from gaitsim_spider.intervals import SIZE

_f = np.float32
_ZERO, _ONE = _f(0.0), _f(1.0)
_FAR = _f(1e9)


@njit(error_model="numpy")
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


@njit(error_model="numpy")
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
