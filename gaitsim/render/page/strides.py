"""One stride of each gait, cut out of its motion."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SETTLED = 0.15  # of the motion: what comes before may be the way from standing into the gait
_SEARCHED = 4  # harmonics by which the period is found
_SAME = 0.02  # of the greatest difference: strides that differ less are one


def stride_of(angles: Floats) -> tuple[float, Floats]:
    """Return a stride of a gait that has settled.

    Args:
        angles: (frames, joints) rad.

    Returns:
        The stride's period in frames, not a whole number, and the angles of its frames and one
        more, (frames, joints) rad, so that they can be interpolated to its end. Where nothing
        repeats, as before an early fall, all frames after settling, and their number as the period.
    """
    changing = np.flatnonzero(np.diff(angles, axis=0).any(axis=1))
    end = int(changing[-1]) + 2 if len(changing) else len(angles)  # a fallen body stays as it is
    settled = angles[min(int(SETTLED * end), max(end - 2, 0)) : end]
    period = _period(settled)
    if period > len(settled) - 1:
        return float(len(settled)), settled
    return period, settled[: int(np.ceil(period)) + 1]


def _basis(frames: int, period: float, harmonics: int) -> Floats:
    """Return 1, cosines and sines over time, (frames, 1 + 2 harmonics)."""
    turns = 2 * np.pi / period * np.outer(np.arange(frames), np.arange(1, harmonics + 1))
    return np.concatenate([np.ones((frames, 1)), np.cos(turns), np.sin(turns)], axis=1)


def _period(angles: Floats) -> float:
    """Return the period of joint angles, (frames, joints), in frames; their number without one.

    The first shift by whole frames that hardly changes them, refined by least squares.
    """
    frames = len(angles)
    if frames < 6:
        return float(frames)
    lags = np.arange(2, int(0.85 * frames) + 1)
    differences = np.array([np.mean((angles[lag:] - angles[:-lag]) ** 2) for lag in lags])
    if not differences.max() > 0:
        return float(frames)
    near = differences <= differences.min() + _SAME * differences.max()
    # Only after a shift that changes them: neighbours in time are alike, too.
    first = int(np.argmax(differences > differences.max() / 3))
    candidates = np.flatnonzero(near[first:]) + first
    if not len(candidates):
        return float(frames)
    lag = int(candidates[0])
    while lag + 1 < len(lags) and differences[lag + 1] < differences[lag]:
        lag += 1
    if lag + 1 == len(lags):  # they end before it is known where they are alike again
        return float(frames)
    guess = float(lags[lag])
    for reach, count in ((0.75, 16), (0.06, 9), (0.01, 9)):
        tried = guess + np.linspace(-reach, reach, count)
        guess = float(min(tried, key=lambda period: _misfit(angles, period)))
    return guess


def _misfit(angles: Floats, period: float) -> float:
    basis = _basis(len(angles), period, max(1, min(_SEARCHED, int(period / 2))))
    orthonormal = np.linalg.qr(basis)[0]
    return float(np.sum((angles - orthonormal @ (orthonormal.T @ angles)) ** 2))
