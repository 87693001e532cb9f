"""Quantities that several reflexes compute from observations, in Python and in C."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Floats, Observation

DEGREE = math.pi / 180  # rad


def course_error(seen: Observation) -> Floats:
    """Return the angle to the left from the measured yaw to the heading, −π to π rad."""
    error = seen.heading - seen.orientation[:, 2]
    nearest: Floats = error - 2 * np.pi * np.floor((error + np.pi) / (2 * np.pi))
    return nearest


def walking(seen: Observation) -> NDArray[np.bool_]:
    """Return which individuals are commanded to walk, (population,); the others stand."""
    walks: NDArray[np.bool_] = (seen.command[:, :3] != 0).any(axis=1)
    return walks


def of_legs(value: Any) -> Any:
    """Return an option for arrays (population, legs): a number, or (population, 1)."""
    return np.asarray(value)[..., None]


COURSE_ERROR = """\
const double turn = 2 * 3.141592653589793;
double error = seen->heading - seen->orientation[2];
error -= turn * floor((error + turn / 2) / turn);
"""
"""`course_error` in C, as `error`."""
WALKING = """\
const int walks = seen->command[0] != 0 || seen->command[1] != 0 || seen->command[2] != 0;
"""
"""`walking` in C, as `walks`."""
