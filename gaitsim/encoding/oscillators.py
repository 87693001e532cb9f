"""Oscillators that drive joints: the sine and cpg encodings.

Source of the cpg: A. J. Ijspeert, Central pattern generators for locomotion control in animals
and robots: a review, Neural Networks 21 (2008) 642-653, without its weighting of a coupling by
amplitude.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Oscillators:
    """Oscillators of a body, usually one a leg, and the joints that each drives.

    Both encodings take, and return as (population, joints, frames) rad in `dtype`:

    - amplitude: A, (population, joints) rad;
    - phase: φ of each oscillator, (population, oscillators) rad;
    - lag: λ of each joint, added to the phase of its oscillator, (population, joints) rad;
    - frequency: f, Hz, one for all individuals or (population,).

    They raise ValueError where the shapes do not fit each other.

    Attributes:
        of_joints: index of the oscillator of each joint, (joints,).
        frames: number of frames; the first is at t = 0.
        frame_rate: frames per second, Hz.
        dtype: of the joint angles. float32 halves the time of sines of one frequency.
    """

    of_joints: NDArray[np.intp]
    frames: int
    frame_rate: float
    dtype: DTypeLike = np.float64

    def sine(self, amplitude: Floats, phase: Floats, lag: Floats, frequency: ArrayLike) -> Floats:
        """Return θ(t) = A sin(2πft + φ + λ)."""
        if np.ndim(frequency):
            self._check(amplitude, phase, lag, frequency)
            return self._angles(amplitude, self._phases(phase, frequency), lag)
        sine, cosine, of_sine, of_cosine = self.waves(amplitude, phase, lag, frequency)
        angles: Floats = of_sine[..., None] * sine
        angles += of_cosine[..., None] * cosine
        return angles

    def waves(
        self, amplitude: Floats, phase: Floats, lag: Floats, frequency: ArrayLike
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Return sin 2πft and cos 2πft, (frames,), and the share of each in A sin(2πft + φ + λ).

        By the addition theorem the shares, (population, joints), are A cos(φ + λ) and
        A sin(φ + λ): two products an angle and hardly a sine. One frequency for all individuals.
        """
        self._check(amplitude, phase, lag, frequency)
        joint_phase = phase.take(self.of_joints, axis=1) + lag
        step = 2 * math.pi * np.asarray(frequency, np.float64) / self.frame_rate
        cycle = step * np.arange(self.frames)
        shares = amplitude * np.cos(joint_phase), amplitude * np.sin(joint_phase)
        return (
            self._cast(np.sin(cycle)),
            self._cast(np.cos(cycle)),
            self._cast(shares[0]),
            self._cast(shares[1]),
        )

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

        The phases ϑ start at `start` and settle on the differences of φ. Coupled to all,
        ϑ̇ᵢ = 2πf + Σⱼ k sin(ϑⱼ − ϑᵢ − (φⱼ − φᵢ)); to a leader, ϑ̇ᵢ = 2πf + k sin(2πft + φᵢ − ϑᵢ).

        The amplitude r grows from 0 to A, critically damped: r̈ = a(a/4 (A − r) − ṙ), with the
        solution A(1 − e^(−at/2)(1 + at/2)).

        Args:
            amplitude: A; see the class for this and the next three.
            phase: φ.
            lag: λ.
            frequency: f.
            start: ϑ at t = 0, (oscillators,) rad. Choose a gait, such as a trot: a gait whose
                sides alternate would pull equal phases both ways alike and never settle.
            coupling: 'all' couples each oscillator to every other, integrated by the fourth-order
                Runge-Kutta method with one step a frame; 'leader' couples each to one leading
                oscillator, which has a closed form.
            strength: k, 1/s, of the coupling to each of the others or to the leader.
            gain: a, 1/s.
        """
        self._check(amplitude, phase, lag, frequency)
        seconds = np.arange(self.frames) / self.frame_rate
        # The deviation from the settled phases, ϑ − 2πft − φ, does not depend on the frequency.
        deviation = np.asarray(start, np.float64) - phase
        settle = _coupled_to_all if coupling == "all" else _coupled_to_leader
        phases = settle(deviation, strength, seconds)
        phases += self._phases(phase, frequency)
        growth = 1 - np.exp(-gain / 2 * seconds) * (1 + gain / 2 * seconds)
        return self._angles(growth * amplitude[..., None], phases, lag)

    def _phases(self, phase: Floats, frequency: ArrayLike) -> Floats:
        """2πft + φ, (population, oscillators, frames)."""
        speed = 2 * math.pi * np.asarray(frequency, np.float64)
        return phase[..., None] + speed[..., None, None] * (
            np.arange(self.frames) / self.frame_rate
        )

    def _angles(self, amplitude: Floats, phases: Floats, lag: Floats) -> Floats:
        angles = phases.take(self.of_joints, axis=1)
        angles += lag[..., None]
        np.sin(angles, out=angles)
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
    """Deviations u over time, tan(u/2) = tan(u₀/2) e^(−kt)."""
    within = np.mod(deviation + math.pi, 2 * math.pi) - math.pi
    deviations: Floats = 2 * np.arctan(np.tan(within / 2)[..., None] * np.exp(-strength * seconds))
    return deviations


def _coupled_to_all(deviation: Floats, strength: float, seconds: Floats) -> Floats:
    """Deviations u over time, u̇ᵢ = k Σⱼ sin(uⱼ − uᵢ)."""
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
    """K Σⱼ sin(uⱼ − uᵢ) from the sums over all j, at a cost linear in the oscillators."""
    sine, cosine = np.sin(deviation), np.cos(deviation)
    sines, cosines = (values.sum(axis=1, keepdims=True) for values in (sine, cosine))
    pull: Floats = strength * (sines * cosine - cosines * sine)
    return pull
