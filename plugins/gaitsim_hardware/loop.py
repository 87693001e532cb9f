"""Find the part of a gait that repeats, so that a robot can play it in a loop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOLERANCE = np.radians(1.0)  # rad, largest difference between a cycle and the next
MAX_PERIOD = 0.5  # share of the gait, as every cycle must occur twice
MIN_COMPARED = 0.25  # smallest share of the gait that is compared with the next cycle
MIN_MOTION = np.radians(1.0)  # rad; if all joints turn less, the robot stands still
# rad; the initial transient ends with the last difference above this and above twice the smallest
# error of the loop
TRANSIENT = np.radians(0.1)


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
        angles: joint angles, (frames, joints) rad.
        frame_rate: frames per second, Hz.
    """
    from scipy.interpolate import CubicSpline
    from scipy.optimize import minimize_scalar

    frames = len(angles)
    if frames < 8 or np.ptp(angles[frames // 2 :], axis=0).max() < MIN_MOTION:
        return None
    by_lag = _differences(angles)
    spline = CubicSpline(np.arange(frames), angles)

    def differences(lag: float, first: int) -> Floats:
        times = np.arange(first, int(frames - 1 - lag + 1e-9) + 1)
        return np.asarray(np.abs(spline(times + lag) - angles[first : first + len(times)]).max(1))

    def worst(lag: float) -> float:
        return float(differences(lag, _first_compared(frames, lag)).max())

    inner = by_lag[1:-1]
    minima = 1 + np.flatnonzero((inner <= by_lag[:-2]) & (inner < by_lag[2:]))
    for minimum in minima[by_lag[minima] < by_lag.max() / 2]:
        nearest = int(minimum) + 2
        bounds = nearest - 1, min(nearest + 1.0, MAX_PERIOD * (frames - 1))
        found = minimize_scalar(worst, bounds=bounds, options={"xatol": 1e-4})
        lag = float(found.x)
        error = worst(lag)
        if error <= TOLERANCE:
            errors = differences(lag, 0)
            start = int(np.flatnonzero(errors > max(2 * error, TRANSIENT)).max(initial=-1)) + 1
            return Loop(start / frame_rate, lag / frame_rate, float(errors[start:].max()))
    return None


def _first_compared(frames: int, lag: float) -> int:
    """Return the first frame that is compared with the frame one cycle later."""
    return max(int(frames - 1 - lag - max(lag, MIN_COMPARED * frames)), 0)


def _differences(angles: Floats) -> Floats:
    """Return the largest difference between frames that are 2, 3, … frames apart, rad.

    Only the last part of the gait is compared, as its beginning may be a transient.
    """
    frames = len(angles)
    found = []
    for lag in range(2, int(MAX_PERIOD * (frames - 1)) + 1):
        first = _first_compared(frames, lag)
        found.append(np.abs(angles[first + lag :] - angles[first : frames - lag]).max())
    return np.array(found)
