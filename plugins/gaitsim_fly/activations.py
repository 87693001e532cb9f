"""Activation functions for the compiled flight, without branches so that they vectorise."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.network import LEAKY_RELU, RELU, SIGMOID, TANH, activation_with

_SATURATED = 20.0  # tanh differs from 1 by less than half a unit in the last place


@njit(inline="always", error_model="numpy")
def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent to 1e-13.

    Uses Lambert's continued fraction at x/16, then tanh 2y = 2 tanh y / (1 + tanh² y) four
    times. The system's tanh takes four times as long and differs between systems.
    """
    x = min(max(x, -_SATURATED), _SATURATED)
    y = 0.0625 * x
    z = y * y
    above = y * (2027025.0 + z * (270270.0 + z * (6930.0 + z * 36.0)))
    below = 2027025.0 + z * (945945.0 + z * (51975.0 + z * (630.0 + z)))
    t = above / below
    for _ in range(4):
        t = (t + t) / (1.0 + t * t)
    return t


_activated = njit(inline="always", error_model="numpy")(activation_with(tanh))


@njit(nogil=True, cache=True, error_model="numpy")
def activate(code: int, x: NDArray[np.float64]) -> None:
    """Apply an activation to every number of a vector, in place."""
    # Separate loops vectorise, unlike one loop that selects the activation.
    if code == TANH:
        for i in range(len(x)):
            x[i] = _activated(TANH, x[i])
    elif code == SIGMOID:
        for i in range(len(x)):
            x[i] = _activated(SIGMOID, x[i])
    elif code == RELU:
        for i in range(len(x)):
            x[i] = _activated(RELU, x[i])
    else:
        for i in range(len(x)):
            x[i] = _activated(LEAKY_RELU, x[i])
