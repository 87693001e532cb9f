"""The cycle of a gait: the legs reach, then straighten and carry the body."""

import math

import numpy as np
from numpy.typing import NDArray

FRAME_RATE = 30.0  # Hz
REACH = 15  # frames of a cycle in which the lifted legs reach
CYCLE = 30  # frames; after the reach, the legs straighten on the ground
CYCLES = 10
FRAMES = CYCLES * CYCLE
LIFT = math.radians(15.0)  # angle of a leg above the ground in the middle of its reach

_frame = np.arange(FRAMES) % CYCLE

STANCE: NDArray[np.bool_] = _frame >= REACH
"""Whether the feet stay on the ground until the next frame, (frames,)."""

EXTENT: NDArray[np.float64] = (1 - np.cos(2 * np.pi * _frame / CYCLE)) / 2
"""Extent of the legs' reach, (frames,): 0 straight, 1 at their full angle."""

LIFTED: NDArray[np.float64] = np.where(STANCE, 0.0, LIFT * np.sin(np.pi * _frame / REACH))
"""Angle of the legs above the ground, (frames,), radians."""

PROGRESS: NDArray[np.float64] = np.where(STANCE, 1 - EXTENT, 0.0) + np.arange(FRAMES) // CYCLE
"""Distance that the body has moved, in units of its motion per cycle, (frames,)."""
