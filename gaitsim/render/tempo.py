"""The frequency of a body's movement, and the speed at which a video can show it."""

import math

import numpy as np

from gaitsim.contracts import Skeleton

ALIASED = 2.0  # frames per cycle; with fewer, movement appears to run backwards
TOO_FEW = 6.0  # frames per cycle; with fewer, movement is jerky
ENOUGH = 8.0  # frames per cycle in slow motion
_FRACTIONS = {0.5: "½", 0.25: "¼", 0.125: "⅛"}


def movement_frequency(skeleton: Skeleton) -> float:
    """Return the frequency of a body's movement about its path, Hz; 0 if it does not move.

    It is the median of the power spectrum of the velocities of all points, such as the frequency
    of the wing beat or the stride.
    """
    segments = np.asarray(skeleton.segments, dtype=np.float64)
    about = segments - np.asarray(skeleton.path, dtype=np.float64)[:, None, None]
    about = about.reshape(len(about), -1)
    # The window removes the jump between the end and the start.
    window = np.hanning(len(about))[:, None]
    frequencies = np.fft.rfftfreq(len(about), 1 / skeleton.frame_rate)
    places = np.fft.rfft((about - about.mean(axis=0)) * window, axis=0)
    power = np.cumsum((np.abs(places) ** 2).sum(axis=1) * frequencies**2)
    if not power[-1] > (1e-9 * np.abs(about).max(initial=0.0)) ** 2:
        return 0.0
    return float(frequencies[np.searchsorted(power, power[-1] / 2)])


def is_resolved(frequency: float, rate: float, speed: float, frames: float = TOO_FEW) -> bool:
    """Return whether each cycle of a movement has at least `frames` frames.

    Args:
        frequency: frequency of the movement, Hz.
        rate: frames per second of the video.
        speed: speed of the motion; 1 is real time.
        frames: minimum number of frames per cycle.
    """
    return frequency * speed * frames <= rate


def default_speed(frequency: float, rate: float, slowest: float) -> float:
    """Return 1, or the slow motion (½, ¼, ⅛ …) that a fast movement needs.

    Args:
        frequency: frequency of the movement, Hz.
        rate: frames per second of the video.
        slowest: lower limit of the speed.
    """
    if is_resolved(frequency, rate, 1.0):
        return 1.0
    halvings = math.ceil(math.log2(frequency * ENOUGH / rate))
    return float(2.0 ** -min(halvings, math.floor(-math.log2(slowest))))


def format_speed(speed: float) -> str:
    """Format a speed, such as '¼ speed' or '4 × speed'."""
    whole = round(1 / speed) if speed < 1 else 0
    if speed in _FRACTIONS:
        return f"{_FRACTIONS[speed]} speed"
    if whole and math.isclose(speed * whole, 1):
        return f"1/{whole} speed"
    return f"{speed:g} × speed"
