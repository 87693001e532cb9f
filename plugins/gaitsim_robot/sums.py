"""Sums over an individual's motion, in an order that the rest of the population does not change."""

import math

import numpy as np

from gaitsim.contracts import Array
from gaitsim_robot.anatomy import Floats


def total(values: Array) -> Floats:
    """Sum over all axes but the population, (population, …) -> (population,).

    NumPy adds each row of a contiguous array alone.
    """
    rows = np.ascontiguousarray(values, np.float64).reshape(len(values), -1)
    summed: Floats = np.add.reduce(rows, axis=1)
    return summed


def mean(values: Array) -> Floats:
    """Mean over all axes but the population, (population,)."""
    return total(values) / math.prod(values.shape[1:])


def rms(values: Array) -> Floats:
    """Root mean square over all axes but the population, (population,)."""
    return np.sqrt(mean(np.square(values)))


def ratio(part: Array, whole: Array, otherwise: float = 0.0) -> Floats:
    """Part over whole, in the shape of `part`; `otherwise` where the whole is 0."""
    found: Floats = np.divide(part, whole, out=np.full(part.shape, otherwise), where=whole > 0)
    return found
