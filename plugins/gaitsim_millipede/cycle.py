"""The cycle of a gait over time: the legs reach, then straighten and carry the body."""

import math

import numpy as np
from numpy.typing import NDArray

FRAME_RATE = 30.0  # Hz
REACH = 15  # frames in which the legs reach, lifted
CYCLE = 30  # frames; in the others the legs straighten, on the ground
CYCLES = 10
FRAMES = CYCLES * CYCLE
LIFT = math.radians(15.0)  # of a leg in the middle of its reach

_frame = np.arange(FRAMES) % CYCLE

STANCE: NDArray[np.bool_] = _frame >= REACH
"""(frames,): whether the feet are on the ground until the next frame."""

EXTENT: NDArray[np.float64] = (1 - np.cos(2 * np.pi * _frame / CYCLE)) / 2
"""(frames,): how far the legs are out, 0 straight, 1 at their full angle."""

LIFTED: NDArray[np.float64] = np.where(STANCE, 0.0, LIFT * np.sin(np.pi * _frame / REACH))
"""(frames,): angle of the legs above the ground, radians."""

PROGRESS: NDArray[np.float64] = np.where(STANCE, 1 - EXTENT, 0.0) + np.arange(FRAMES) // CYCLE
"""(frames,): cycles by which the body has moved."""
