"""The cycle of a gait: the legs reach, then straighten and carry the body."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import scalar_cos as cos, scalar_sin as sin

FRAME_RATE = 30.0  # Hz
REACH = 15  # frames of a cycle in which the lifted legs reach
CYCLE = 30  # frames; after the reach, the legs straighten on the ground
CYCLES = 10
FRAMES = CYCLES * CYCLE
LIFT = math.radians(15.0)  # angle of a leg above the ground in the middle of its reach

_frame = np.arange(FRAMES) % CYCLE


def _repeated(function: Callable[[Any], Any], period: int) -> NDArray[np.float64]:
    """Return a sine or cosine of time in all cycles, (frames,); `period` is in frames."""
    return np.tile([float(function(2 * math.pi * n / period)) for n in range(CYCLE)], CYCLES)


STANCE: NDArray[np.bool_] = _frame >= REACH
"""Whether the feet stay on the ground until the next frame, (frames,)."""

EXTENT: NDArray[np.float64] = (1 - _repeated(cos, CYCLE)) / 2
"""Extent of the legs' reach, (frames,): 0 straight, 1 at their full angle."""

LIFTED: NDArray[np.float64] = np.where(STANCE, 0.0, LIFT * _repeated(sin, 2 * REACH))
"""Angle of the legs above the ground, (frames,), radians."""

PROGRESS: NDArray[np.float64] = np.where(STANCE, 1 - EXTENT, 0.0) + np.arange(FRAMES) // CYCLE
"""Distance that the body has moved, in units of its motion per cycle, (frames,)."""
