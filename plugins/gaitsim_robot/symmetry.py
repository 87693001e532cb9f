"""Symmetries of gaits: the legs that share genes, and the phase of each leg."""

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.anatomy import Anatomy, Floats

Symmetry = Literal["none", "alternating", "trot", "bound", "wave"]


def rows(anatomy: Anatomy) -> NDArray[np.intp]:
    """Return the row of each leg from front to back, 0 first, (legs,)."""
    return np.array([int(leg.name[1:]) - 1 for leg in anatomy.legs], np.intp)


def leaders(anatomy: Anatomy, symmetry: Symmetry) -> NDArray[np.intp]:
    """Return the index of the leg whose genes each leg uses, (legs,).

    With a symmetry, it is the left leg of the row, if both legs have equally many joints.
    """
    index = {leg.name: at for at, leg in enumerate(anatomy.legs)}
    found = []
    for at, leg in enumerate(anatomy.legs):
        left = index.get("L" + leg.name[1:], at) if leg.side == "right" else at
        alike = len(anatomy.legs[left].joints) == len(leg.joints)
        found.append(left if symmetry != "none" and alike else at)
    return np.array(found, np.intp)


def phases(anatomy: Anatomy, symmetry: Symmetry, lag: Floats) -> Floats:
    """Return the phase of each leg in its cycle, (population, legs) rad.

    - alternating: half a cycle between left and right, and between neighbours on a side: the walk
      of two legs, the trot of four, the tripods of six, the tetrapods of eight.
    - trot: the same as alternating, under its name for four legs.
    - bound: both legs of a row together, and half a cycle between neighbouring rows.
    - wave: half a cycle between left and right; each row starts `lag` after the row behind it.

    Args:
        anatomy: anatomy of the robot.
        symmetry: any symmetry except none.
        lag: delay between rows in a wave, (population,) rad; unused otherwise.
    """
    row = rows(anatomy)
    right = np.array([leg.side == "right" for leg in anatomy.legs], np.float64)
    if symmetry == "wave":
        return np.asarray(math.pi * right - lag[:, None] * (row.max() - row))
    halves = row if symmetry == "bound" else row + right
    return np.broadcast_to(math.pi * (halves % 2), (len(lag), len(row))).copy()
