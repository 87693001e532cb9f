"""Find the part of a gait that repeats, so that a robot can play it in a loop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOLERANCE = np.radians(1.0)  # rad, largest difference between a cycle and the next
SET_OFF = np.radians(0.1)  # rad, or twice the difference of cycles; more is the initial transient
LONGEST = 0.5  # share of the gait, as every cycle must occur twice
WATCHED = 0.25  # smallest share of the gait that is compared with the next cycle
STILL = np.radians(1.0)  # rad; the gait stands still if all joints turn less


@dataclass(frozen=True)
class Loop:
    """A part of a gait that repeats.

    Attributes:
        start: start of the first cycle, after the initial transient, s.
        period: duration of a cycle, s.
        error: largest difference between a cycle and the next, rad.
    """

    start: float
    period: float
    error: float


def find_loop(angles: Floats, frame_rate: float) -> Loop | None:
    """Return the shortest part of a gait that repeats to within 1°; None if no part does.

    The joint angles must repeat, not only the contacts of the feet. A period need not be a whole
    number of frames, as a cubic spline interpolates the angles.

    Args:
        angles: (frames, joints) rad.
        frame_rate: frames per second, Hz.
    """
    from scipy.interpolate import CubicSpline
    from scipy.optimize import minimize_scalar

    frames = len(angles)
    if frames < 8 or np.ptp(angles[frames // 2 :], axis=0).max() < STILL:
        return None
    coarse = _differences(angles)
    spline = CubicSpline(np.arange(frames), angles)

    def differences(lag: float, first: int) -> Floats:
        times = np.arange(first, int(frames - 1 - lag + 1e-9) + 1)
        return np.asarray(np.abs(spline(times + lag) - angles[first : first + len(times)]).max(1))

    def worst(lag: float) -> float:
        return float(differences(lag, _first(frames, lag)).max())

    inner = coarse[1:-1]
    lows = 1 + np.flatnonzero((inner <= coarse[:-2]) & (inner < coarse[2:]))
    for low in lows[coarse[lows] < coarse.max() / 2]:
        near = int(low) + 2
        bounds = near - 1, min(near + 1.0, LONGEST * (frames - 1))
        found = minimize_scalar(worst, bounds=bounds, options={"xatol": 1e-4})
        lag = float(found.x)
        least = worst(lag)
        if least <= TOLERANCE:
            apart = differences(lag, 0)
            start = int(np.flatnonzero(apart > max(2 * least, SET_OFF)).max(initial=-1)) + 1
            return Loop(start / frame_rate, lag / frame_rate, float(apart[start:].max()))
    return None


def _first(frames: int, lag: float) -> int:
    """Return the first frame that is compared with the frame one cycle later."""
    return max(int(frames - 1 - lag - max(lag, WATCHED * frames)), 0)


def _differences(angles: Floats) -> Floats:
    """Return the largest difference after lags of 2, 3, … frames at the end of the gait, rad."""
    frames = len(angles)
    found = []
    for lag in range(2, int(LONGEST * (frames - 1)) + 1):
        first = _first(frames, lag)
        found.append(np.abs(angles[first + lag :] - angles[first : frames - lag]).max())
    return np.array(found)
