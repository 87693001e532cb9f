"""The time axis: second in a motion's channels, last in the compiled kernels."""

import numpy as np

from gaitsim.contracts import Array


def time_second(array: Array) -> Array:
    """View (population, …, frames) as the channel (population, frames, …), axes reversed."""
    return array.transpose(0, *range(array.ndim - 1, 0, -1))


def time_last(channel: Array) -> Array:
    """Invert `time_second`; contiguous, and a copy only if the channel is not such a view."""
    return np.ascontiguousarray(time_second(channel))
