"""Oscillators that drive joints: the sine and cpg encodings.

Source of the cpg: A. J. Ijspeert, Central pattern generators for locomotion control in animals
and robots: a review, Neural Networks 21 (2008) 642-653. Unlike in that paper, couplings are not
weighted by amplitude.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from gaitsim.portable import arctan, cos, exp, sin, tan

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Oscillators:
    """The oscillators of a body, usually one per leg, and the joints that they drive.

    Both encodings return joint angles, (population, joints, frames) rad in `dtype`, and take:

    - amplitude: amplitude A of each joint, (population, joints) rad;
    - phase: phase φ of each oscillator, (population, oscillators) rad;
    - lag: lag λ of each joint, added to the phase of its oscillator, (population, joints) rad;
    - frequency: frequency f, Hz, one for all individuals or (population,).

    They raise ValueError if the shapes do not match each other.

    Attributes:
        of_joints: index of the oscillator of each joint, (joints,).
        frames: number of frames; the first is at t = 0.
        frame_rate: frames per second, Hz.
        dtype: dtype of the joint angles. With one frequency for all individuals, float32 halves
            the time of `sine`.
    """

    of_joints: NDArray[np.intp]
    frames: int
    frame_rate: float
    dtype: DTypeLike = np.float64

    def sine(self, amplitude: Floats, phase: Floats, lag: Floats, frequency: ArrayLike) -> Floats:
        """Return θ(t) = A sin(2πft + φ + λ).

        If all individuals have one frequency, the addition theorem replaces the sine of each angle
        by two products.
        """
        self._check(amplitude, phase, lag, frequency)
        if np.ndim(frequency):
            return self._angles(amplitude, self._phases(phase, frequency), lag)
        joint_phase = phase.take(self.of_joints, axis=1) + lag
        step = 2 * math.pi * np.asarray(frequency, np.float64) / self.frame_rate
        cycle = step * np.arange(self.frames)
        of_sine = self._cast(amplitude * cos(joint_phase))[..., None]
        of_cosine = self._cast(amplitude * sin(joint_phase))[..., None]
        angles: Floats = of_sine * self._cast(sin(cycle))
        angles += of_cosine * self._cast(cos(cycle))
        return angles

    def cpg(
        self,
        amplitude: Floats,
        phase: Floats,
        lag: Floats,
        frequency: ArrayLike,
        *,
        start: ArrayLike,
        coupling: Literal["all", "leader"] = "all",
        strength: float = 1.0,
        gain: float = 10.0,
    ) -> Floats:
        """Return θ = r sin(ϑ + λ) of coupled phase oscillators that start from a standing pose.

        The phases ϑ start at `start` and converge to the phase differences of φ. With the coupling
        'all', ϑ̇ᵢ = 2πf + Σⱼ k sin(ϑⱼ − ϑᵢ − (φⱼ − φᵢ)). With the coupling 'leader',
        ϑ̇ᵢ = 2πf + k sin(2πft + φᵢ − ϑᵢ).

        The amplitude r grows from 0 to A, critically damped: r̈ = a(a/4 (A − r) − ṙ), with the
        solution A(1 − e^(−at/2)(1 + at/2)).

        Args:
            amplitude: amplitude A. The class describes this and the next three arguments.
            phase: phase φ.
            lag: lag λ.
            frequency: frequency f.
            start: phases ϑ at t = 0, (oscillators,) rad. Choose the phases of a gait, such as a
                trot. If all were equal, an alternating gait would pull them equally in both
                directions, and they would never converge.
            coupling: 'all' couples each oscillator to every other; the equations are integrated
                with the fourth-order Runge-Kutta method, one step per frame. 'leader' couples each
                oscillator to a leading one, which has a closed-form solution.
            strength: strength k of the coupling to each other oscillator or to the leader, 1/s.
            gain: gain a of the amplitude's growth, 1/s.
        """
        self._check(amplitude, phase, lag, frequency)
        seconds = np.arange(self.frames) / self.frame_rate
        # The deviation from the final phases, ϑ − 2πft − φ, does not depend on the frequency.
        deviation = np.asarray(start, np.float64) - phase
        settle = _coupled_to_all if coupling == "all" else _coupled_to_leader
        phases = settle(deviation, strength, seconds)
        phases += self._phases(phase, frequency)
        growth = 1 - exp(-gain / 2 * seconds) * (1 + gain / 2 * seconds)
        return self._angles(growth * amplitude[..., None], phases, lag)

    def _phases(self, phase: Floats, frequency: ArrayLike) -> Floats:
        """Return 2πft + φ, (population, oscillators, frames)."""
        speed = 2 * math.pi * np.asarray(frequency, np.float64)
        return phase[..., None] + speed[..., None, None] * (
            np.arange(self.frames) / self.frame_rate
        )

    def _angles(self, amplitude: Floats, phases: Floats, lag: Floats) -> Floats:
        angles = phases.take(self.of_joints, axis=1)
        angles += lag[..., None]
        angles = sin(angles)
        angles *= amplitude if amplitude.ndim == angles.ndim else amplitude[..., None]
        return self._cast(angles)

    def _cast(self, values: Floats) -> Floats:
        return values.astype(self.dtype, copy=False)

    def _check(self, amplitude: Floats, phase: Floats, lag: Floats, frequency: ArrayLike) -> None:
        population, joints = len(amplitude), len(self.of_joints)
        for name, values, shape in (
            ("amplitude", amplitude, (population, joints)),
            ("phase", phase, (population, int(self.of_joints.max()) + 1)),
            ("lag", lag, (population, joints)),
            ("frequency", frequency, (population,) if np.ndim(frequency) else ()),
        ):
            if np.shape(values) != shape:
                raise ValueError(f"{name} has the shape {np.shape(values)}, expected {shape}")


def _coupled_to_leader(deviation: Floats, strength: float, seconds: Floats) -> Floats:
    """Return the deviations u over time, tan(u/2) = tan(u₀/2) e^(−kt)."""
    within = np.mod(deviation + math.pi, 2 * math.pi) - math.pi
    deviations: Floats = 2 * arctan(tan(within / 2)[..., None] * exp(-strength * seconds))
    return deviations


def _coupled_to_all(deviation: Floats, strength: float, seconds: Floats) -> Floats:
    """Return the deviations u over time, u̇ᵢ = k Σⱼ sin(uⱼ − uᵢ)."""
    deviations = np.empty((*deviation.shape, len(seconds)))
    step = float(seconds[1]) if len(seconds) > 1 else 0.0
    for frame in range(len(seconds)):
        deviations[:, :, frame] = deviation
        deviation = _runge_kutta(deviation, strength, step)
    return deviations


def _runge_kutta(state: Floats, strength: float, dt: float) -> Floats:
    k1 = _attraction(state, strength)
    k2 = _attraction(state + dt / 2 * k1, strength)
    k3 = _attraction(state + dt / 2 * k2, strength)
    k4 = _attraction(state + dt * k3, strength)
    return state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def _attraction(deviation: Floats, strength: float) -> Floats:
    """Return k Σⱼ sin(uⱼ − uᵢ) from sums over all j, at a cost linear in the oscillators."""
    sine, cosine = sin(deviation), cos(deviation)
    sines, cosines = (values.sum(axis=1, keepdims=True) for values in (sine, cosine))
    pull: Floats = strength * (sines * cosine - cosines * sine)
    return pull
