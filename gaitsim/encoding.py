"""Encodings, which turn genomes into joint angles over time, for any number of joints.

A body declares groups of genes (`GeneGroup`), builds its genome space from them
(`genome_space`), and decodes a population in two steps: `split_genomes` returns the values of
each group, and `Oscillators.sine` or `Oscillators.cpg` converts them to joint angles.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from gaitsim.contracts import Dimension, Genomes, RealSpace, factor_bounds
from gaitsim.portable import arctan, cos, exp, sin, tan


@dataclass(frozen=True)
class GeneGroup:
    """Genes that set the same quantity for several parts of a body.

    Attributes:
        name: name of the quantity, such as 'amplitude'.
        parts: part that each gene belongs to, such as 'L1 coxa'; '' for the whole body.
        lower: smallest value, one for all parts or (parts,).
        upper: largest value, one for all parts or (parts,).
        periodic: whether the values are angles of a cycle; see `RealSpace`.
        mirror: offset between the two sides of the body, such as π for the phase of an
            alternating gait. Each part in `parts` then has a counterpart on the other side without
            a gene, whose value is that of the part plus `mirror`. None for a body in which every
            part has its own gene.

    Examples:
        Two legs with hips and knees alternate. The right leg has no genes of its own: it has the
        amplitudes and lags of the left leg, and moves half a stride later.

        >>> joints = ("left hip", "left knee", "right hip", "right knee")
        >>> largest = float(amplitude_limit(1.5, angle_limit=0.5, speed_limit=3.0))
        >>> groups = (
        ...     GeneGroup("amplitude", joints, 0.0, largest).halved(mirror=0.0),
        ...     GeneGroup("phase", ("left", "right"), -np.pi, np.pi, True).halved(mirror=np.pi),
        ...     GeneGroup("lag", joints, -np.pi, np.pi, periodic=True).halved(mirror=0.0),
        ... )
        >>> space = genome_space(groups)
        >>> space.labels
        ('left hip amplitude', 'left knee amplitude', 'left phase', 'left hip lag', 'left knee lag')
        >>> genomes = space.random(10, np.random.default_rng(0))
        >>> amplitude, phase, lag = split_genomes(genomes, groups)
        >>> legs = Oscillators(np.array([0, 0, 1, 1]), frames=300, frame_rate=30.0)
        >>> legs.sine(amplitude, phase, lag, 1.5).shape  # (population, joints, frames)
        (10, 4, 300)
    """

    name: str
    parts: tuple[str, ...]
    lower: ArrayLike
    upper: ArrayLike
    periodic: bool = False
    mirror: float | None = None

    def halved(self, mirror: float) -> "GeneGroup":
        """Return the group with genes for the first half of its parts, which the rest mirror."""
        return replace(self, parts=self.parts[: len(self.parts) // 2], mirror=mirror)


def genome_space(groups: Sequence[GeneGroup]) -> RealSpace:
    """Return the space of genomes that hold the groups in order.

    Raises:
        ValueError: a lower bound is not below its upper bound, or bounds are not finite or do not
            match the parts.
    """
    count = [len(group.parts) for group in groups]
    return RealSpace(
        lower=_bounds_by_gene([group.lower for group in groups], count),
        upper=_bounds_by_gene([group.upper for group in groups], count),
        labels=tuple(f"{part} {group.name}".strip() for group in groups for part in group.parts),
        periodic=np.repeat([group.periodic for group in groups], count),
    )


def dimension_genes(
    space: Mapping[str, Dimension], evolve: Sequence[str], ranges: Mapping[str, Sequence[float]]
) -> tuple[GeneGroup, ...]:
    """Return the genes of the dimensions that evolve, factors; () if none does.

    They are the last genes of a genome; see `Organism.embody`.
    """
    lower, upper = factor_bounds(space, evolve, ranges)
    return (GeneGroup("dimension", tuple(evolve), lower, upper),) if evolve else ()


def split_genomes(genomes: Genomes, groups: Sequence[GeneGroup]) -> tuple[NDArray[np.float64], ...]:
    """Return the values of each group, (population, parts), mirrored parts last.

    Args:
        genomes: genomes in `genome_space(groups)`, (population, genes).
        groups: groups in the order of the genome.

    Raises:
        ValueError: the number of genes does not match the groups.
    """
    ends = np.cumsum([len(group.parts) for group in groups])
    if genomes.ndim != 2 or genomes.shape[1] != ends[-1]:
        raise ValueError(
            f"genomes have the shape {genomes.shape}, expected (population, {ends[-1]})"
        )
    return tuple(
        values if group.mirror is None else np.hstack([values, values + group.mirror])
        for group, values in zip(groups, np.split(genomes, ends[:-1], axis=1), strict=True)
    )


def _bounds_by_gene(bounds: Sequence[ArrayLike], counts: Sequence[int]) -> NDArray[np.float64]:
    return np.concatenate(
        [
            np.broadcast_to(np.asarray(bound, np.float64), count)
            for bound, count in zip(bounds, counts, strict=True)
        ]
    )


def amplitude_limit(
    frequency: float, angle_limit: ArrayLike, speed_limit: ArrayLike
) -> NDArray[np.float64]:
    """Return the largest amplitude with which a sine stays within both limits of its joint.

    The largest speed of a sine of amplitude A is 2πAf.

    Args:
        frequency: frequency f of the sine, Hz.
        angle_limit: largest absolute angle, rad, for all joints or (joints,).
        speed_limit: largest angular speed, rad/s, for all joints or (joints,).

    Returns:
        The amplitude, rad, in the common shape of both limits.
    """
    speed = np.asarray(speed_limit, np.float64) / (2 * math.pi * frequency)
    return np.asarray(np.minimum(np.asarray(angle_limit, np.float64), speed))


def check_joint_angles(joint_angles: NDArray[Any], joints: int) -> None:
    """Check joint angles, (population, frames, joints) rad, that a body is to play.

    Raises:
        ValueError: the shape is different, there are fewer than 2 frames, or angles are not finite.
    """
    shape = joint_angles.shape
    if len(shape) != 3 or shape[1] < 2 or shape[2] != joints:
        raise ValueError(
            f"joint_angles has the shape {shape}, expected (population, frames, joints) with at "
            f"least 2 frames and {joints} joints"
        )
    if not np.isfinite(joint_angles).all():
        raise ValueError("some joint_angles are not finite")


def check_time_step(dt: float, frame_rate: float) -> None:
    """Check that a frame has a whole number of a simulation's time steps.

    Args:
        dt: time step, s.
        frame_rate: frames per second, Hz.

    Raises:
        ValueError: the number of time steps is not whole; the message suggests a similar time step.
    """
    steps = 1 / (frame_rate * dt)
    if not math.isclose(steps, round(steps), rel_tol=1e-3):
        near = 1 / (frame_rate * round(steps))
        raise ValueError(
            f"a frame of 1/{frame_rate:g} s is not a whole number of time steps of {dt:g} s; "
            f"{near:.4g} s divides it"
        )


def limit_steps(
    angles: NDArray[np.floating[Any]], step_limit: ArrayLike
) -> NDArray[np.floating[Any]]:
    """Return the angles of servos that follow `angles` but turn at most `step_limit` per frame.

    Angles within the limit are returned unchanged, bit for bit.

    Args:
        angles: commanded angles, (population, joints, frames) rad; not changed.
        step_limit: largest change from frame to frame, rad, for all joints or (joints,).

    Returns:
        The angles of the servos, (population, joints, frames) rad, in the dtype of `angles`.
    """
    limited = angles.copy()
    step = np.asarray(step_limit, angles.dtype)
    for frame in range(1, angles.shape[2]):
        before = limited[:, :, frame - 1]
        limited[:, :, frame] = np.clip(angles[:, :, frame], before - step, before + step)
    return limited


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
