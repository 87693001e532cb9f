"""What both encodings share: phases that advance evenly, and the angles of driven joints."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.floating[Any]]


def checked(
    amplitude: Floats,
    phase: Floats,
    lag: Floats,
    frequency: ArrayLike,
    oscillators: NDArray[np.intp],
) -> None:
    """Check the shapes that `sine` and `cpg` take.

    Raises:
        ValueError: shapes that do not fit each other.
    """
    population, joints = len(amplitude), len(oscillators)
    expected = {
        "amplitude": (amplitude, (population, joints)),
        "lag": (lag, (population, joints)),
        "phase": (phase, (population, *phase.shape[1:2])),
    }
    for name, (values, shape) in expected.items():
        if values.shape != shape or len(shape) != 2:
            raise ValueError(f"{name} has the shape {values.shape}, expected {shape}")
    if np.shape(frequency) not in ((), (population,)):
        raise ValueError(
            f"frequency has the shape {np.shape(frequency)}, expected () or ({population},)"
        )
    if joints and not 0 <= oscillators.min() <= oscillators.max() < phase.shape[1]:
        raise ValueError(
            f"oscillators holds {oscillators.min()} to {oscillators.max()}, expected indices "
            f"from 0 to {phase.shape[1] - 1}"
        )


def phases(phase: Floats, frequency: ArrayLike, frames: int, frame_rate: float) -> Floats:
    """Return 2πft + φ, (population, oscillators, frames) rad."""
    seconds = np.arange(frames) / frame_rate
    speed = 2 * math.pi * np.asarray(frequency, np.float64)
    return phase[:, :, None] + speed[..., None, None] * seconds


def waves(amplitude: Floats, cycles: Floats, lag: Floats, growth: Floats | None = None) -> Floats:
    """Return A g(t) sin(φ(t) + λ), (population, joints, frames); overwrites `cycles`, φ(t)."""
    cycles += lag[..., None]
    np.sin(cycles, out=cycles)
    cycles *= amplitude[..., None] if growth is None else growth * amplitude[..., None]
    return cycles
