"""Extraction of one stride from a motion."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SETTLED = 0.15  # share of the motion at its start in which the gait may not have settled
_SEARCHED = 4  # number of harmonics in the search for the period
_MAX_DIFFERENCE = 0.02  # differences of equal strides, as a share of the greatest difference


def stride_of(angles: Floats) -> tuple[float, Floats]:
    """Return a stride of a gait after it has settled.

    Args:
        angles: (frames, joints) rad.

    Returns:
        The period of the stride in frames, usually a fraction, and the angles of its frames and
        one more, (frames, joints) rad, so that angles can be interpolated up to the end. For a
        motion that does not repeat, such as one with an early fall, the number of frames after
        settling and their angles.
    """
    changing = np.flatnonzero(np.diff(angles, axis=0).any(axis=1))
    end = int(changing[-1]) + 2 if len(changing) else len(angles)  # a fallen body does not move
    settled = angles[min(int(SETTLED * end), max(end - 2, 0)) : end]
    period = _period(settled)
    if period > len(settled) - 1:
        return float(len(settled)), settled
    return period, settled[: int(np.ceil(period)) + 1]


def _basis(frames: int, period: float, harmonics: int) -> Floats:
    """Return ones, cosines and sines over time, (frames, 1 + 2 harmonics)."""
    turns = 2 * np.pi / period * np.outer(np.arange(frames), np.arange(1, harmonics + 1))
    return np.concatenate([np.ones((frames, 1)), np.cos(turns), np.sin(turns)], axis=1)


def _period(angles: Floats) -> float:
    """Return the period of joint angles (frames, joints) in frames, or `frames` without a period.

    The period is the first shift by whole frames that hardly changes the angles, refined by least
    squares.
    """
    frames = len(angles)
    if frames < 6:
        return float(frames)
    lags = np.arange(2, int(0.85 * frames) + 1)
    differences = np.array([np.mean((angles[lag:] - angles[:-lag]) ** 2) for lag in lags])
    if not differences.max() > 0:
        return float(frames)
    near = differences <= differences.min() + _MAX_DIFFERENCE * differences.max()
    # Skip short shifts, up to the first that changes the angles: neighbouring frames are similar.
    first = int(np.argmax(differences > differences.max() / 3))
    candidates = np.flatnonzero(near[first:]) + first
    if not len(candidates):
        return float(frames)
    lag = int(candidates[0])
    while lag + 1 < len(lags) and differences[lag + 1] < differences[lag]:
        lag += 1
    if lag + 1 == len(lags):  # the motion ends before the minimum
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
