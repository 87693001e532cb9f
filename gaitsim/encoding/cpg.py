"""The cpg encoding: coupled phase oscillators that start from a standing pose.

Source: A. J. Ijspeert, Central pattern generators for locomotion control in animals and robots:
a review, Neural Networks 21 (2008) 642-653, without its weighting of a coupling by amplitude.
"""

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from gaitsim.encoding.waves import Floats, checked, phases, waves


def cpg(
    amplitude: Floats,
    phase: Floats,
    lag: Floats,
    frequency: ArrayLike,
    *,
    oscillators: NDArray[np.intp],
    frames: int,
    frame_rate: float,
    start: ArrayLike,
    coupling: Literal["all", "leader"] = "all",
    strength: float = 1.0,
    gain: float = 10.0,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """Return the joint angles θ = r sin(φ + λ) of coupled phase oscillators.

    The phases φ start at `start` and settle on the differences of the genes ψ. Coupled to all,
    φ̇ᵢ = 2πf + k Σⱼ sin(φⱼ − φᵢ − (ψⱼ − ψᵢ)); coupled to a leader, φ̇ᵢ = 2πf + k sin(2πft + ψᵢ − φᵢ).

    The amplitude grows from 0 to its gene R, critically damped: r̈ = a(a/4 (R − r) − ṙ), with
    the solution R(1 − e^(−at/2)(1 + at/2)).

    Args:
        amplitude: R; this and the arguments up to `frame_rate` are as in `sine`.
        phase: ψ.
        lag: λ.
        frequency: f.
        oscillators: of the joints.
        frames: number of frames.
        frame_rate: frames per second.
        start: φ at t = 0, (oscillators,) rad. Choose a gait, such as a trot: equal phases would
            be pulled both ways alike by a gait whose sides alternate and never settle on it.
        coupling: 'all' couples each oscillator to every other, integrated by the fourth-order
            Runge-Kutta method with one step a frame; 'leader' couples each to one leading
            oscillator, which has a closed form.
        strength: k, 1/s, of the coupling to each of the others or to the leader.
        gain: a, 1/s.
        dtype: of the result; everything is computed in float64.

    Returns:
        (population, joints, frames) rad in `dtype`.

    Raises:
        ValueError: shapes that do not fit each other.
    """
    checked(amplitude, phase, lag, frequency, oscillators)
    seconds = np.arange(frames) / frame_rate
    # The deviation u = φ − 2πft − ψ from the settled phases does not depend on the frequency.
    deviation = np.asarray(start, np.float64) - phase
    settle = _coupled_to_all if coupling == "all" else _coupled_to_leader
    cycles = settle(deviation, strength, seconds)
    cycles += phases(phase, frequency, frames, frame_rate)
    growth = 1 - np.exp(-gain / 2 * seconds) * (1 + gain / 2 * seconds)
    return waves(amplitude, cycles.take(oscillators, axis=1), lag, growth).astype(dtype, copy=False)


def _coupled_to_leader(deviation: Floats, strength: float, seconds: Floats) -> Floats:
    """Return the deviations over time: tan(u/2) = tan(u₀/2) e^(−kt)."""
    within = np.mod(deviation + math.pi, 2 * math.pi) - math.pi
    deviations: Floats = 2 * np.arctan(np.tan(within / 2)[:, :, None] * np.exp(-strength * seconds))
    return deviations


def _coupled_to_all(deviation: Floats, strength: float, seconds: Floats) -> Floats:
    """Return the deviations over time by u̇ᵢ = k Σⱼ sin(uⱼ − uᵢ)."""
    deviations = np.empty((*deviation.shape, len(seconds)))
    step = float(seconds[1]) if len(seconds) > 1 else 0.0
    for frame in range(len(seconds)):
        deviations[:, :, frame] = deviation
        deviation = _runge_kutta(deviation, strength, step)
    return deviations


def _attraction(deviation: Floats, strength: float) -> Floats:
    """Return k Σⱼ sin(uⱼ − uᵢ), by the sums over all, at a cost linear in the oscillators."""
    sine, cosine = np.sin(deviation), np.cos(deviation)
    pull: Floats = _total(sine) * cosine - _total(cosine) * sine
    return strength * pull


def _total(values: Floats) -> Floats:
    return np.asarray(values.sum(axis=1, keepdims=True))


def _runge_kutta(state: Floats, strength: float, dt: float) -> Floats:
    k1 = _attraction(state, strength)
    k2 = _attraction(state + dt / 2 * k1, strength)
    k3 = _attraction(state + dt / 2 * k2, strength)
    k4 = _attraction(state + dt * k3, strength)
    return state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
