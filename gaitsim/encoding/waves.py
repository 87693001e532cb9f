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
    population, count, joints = len(amplitude), phase.shape[-1], len(oscillators)
    for name, values, shape in (
        ("amplitude", amplitude, (population, joints)),
        ("phase", phase, (population, count)),
        ("lag", lag, (population, joints)),
        ("frequency", frequency, (population,) if np.ndim(frequency) else ()),
    ):
        if np.shape(values) != shape:
            raise ValueError(f"{name} has the shape {np.shape(values)}, expected {shape}")
    if not ((oscillators >= 0) & (oscillators < count)).all():
        raise ValueError(f"oscillators is {oscillators}, expected indices from 0 to {count - 1}")


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
