"""Sums over an individual's motion, whose order does not depend on the rest of the population."""

import math

import numpy as np

from gaitsim.contracts import Array
from gaitsim_robot.anatomy import Floats


def total(values: Array) -> Floats:
    """Return the sum of values, (population, …), over all axes but the population, (population,).

    NumPy sums each row of a contiguous array separately.
    """
    rows = np.ascontiguousarray(values, np.float64).reshape(len(values), -1)
    summed: Floats = np.add.reduce(rows, axis=1)
    return summed


def mean(values: Array) -> Floats:
    """Return the mean over all axes but the population, (population,)."""
    return total(values) / math.prod(values.shape[1:])


def rms(values: Array) -> Floats:
    """Return the root mean square over all axes but the population, (population,)."""
    return np.sqrt(mean(np.square(values)))


def ratio(part: Array, whole: Array, otherwise: float = 0.0) -> Floats:
    """Return part / whole in the shape of `part`, and `otherwise` where the whole is 0 or less."""
    found: Floats = np.divide(part, whole, out=np.full(part.shape, otherwise), where=whole > 0)
    return found
