"""How a genome becomes joint angles: the recurrence, sine and cpg encodings."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, RealSpace
from gaitsim_spider import body

Angles = NDArray[np.float32]
"""(population, 24, frames) joint angles, radians from the pose at rest."""

_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Genes:
    """One kind of gene: what it sets, of which parts, within which bounds.

    `periodic` genes are angles of a cycle. `mirror` is what an alternating gait adds
    to a left part's gene to make the right one's; None where there is no such gait.
    """

    what: str
    parts: tuple[str, ...]
    lower: float
    upper: float
    periodic: bool = False
    mirror: float | None = None

    def of(self, symmetric: bool) -> tuple[str, ...]:
        """The parts that have a gene of their own: left ones alone in a symmetric gait."""
        return self.parts[: len(self.parts) // 2] if symmetric else self.parts


@dataclass(frozen=True)
class Encoding:
    """The genes at a frequency in Hz, and the way from genomes to joint angles."""

    genes: Callable[[float], tuple[Genes, ...]]
    decode: Callable[[Genomes, float], Angles]

    def space(self, frequency: float, symmetric: bool) -> RealSpace:
        """The genome space."""
        rows = [(genes, part) for genes in self.genes(frequency) for part in genes.of(symmetric)]
        return RealSpace(
            lower=np.array([genes.lower for genes, _ in rows]),
            upper=np.array([genes.upper for genes, _ in rows]),
            labels=tuple(f"{part} {genes.what}" for genes, part in rows),
            periodic=np.array([genes.periodic for genes, _ in rows]),
        )

    def angles(self, genomes: Genomes, frequency: float, symmetric: bool) -> Angles:
        """Joint angles, the right legs' half a stride after the left ones' if symmetric."""
        if symmetric:
            groups = self.genes(frequency)
            ends = np.cumsum([len(genes.of(symmetric)) for genes in groups])[:-1]
            lefts = np.split(genomes, ends, axis=1)
            genomes = np.concatenate(
                [
                    side
                    for genes, left in zip(groups, lefts, strict=True)
                    for side in (left, left + (genes.mirror or 0.0))
                ],
                axis=1,
            )
        return self.decode(genomes, frequency)


def amplitude_limit(frequency: float) -> float:
    """Largest amplitude, radians, at which a sine of `frequency` Hz keeps both joint limits.

    A sine turns fastest at 2πAf; the limit of 5° a frame holds where A·f ≤ 23.9 °·Hz.
    """
    return min(body.ANGLE_LIMIT, body.STEP_LIMIT * body.FRAME_RATE / (2 * math.pi * frequency))


def _recurrence_genes(_frequency: float) -> tuple[Genes, ...]:
    return (Genes("weight", body.JOINTS, -4.0, 4.0), Genes("bias", body.JOINTS, -0.2, 0.2))


def _recurrence(genomes: Genomes, _frequency: float) -> Angles:
    """θ ← clip(θ + clip(w θ + b, ±5°), ±30°) from rest, for every frame.

    A first-order map of one number: every orbit ends at a fixed point or between two
    values, so its only lasting motion is a flip-flop at half the frame rate.
    """
    from gaitsim_spider.recurrence import recur

    angles = np.empty((len(genomes), len(body.JOINTS), body.FRAMES), dtype=np.float32)
    recur(
        np.ascontiguousarray(genomes, dtype=np.float32),
        np.float32(body.STEP_LIMIT),
        np.float32(body.ANGLE_LIMIT),
        angles,
    )
    return angles


_FOLLOWERS = tuple(joint for joint in body.JOINTS if not joint.endswith("coxa"))


def _oscillator_genes(frequency: float) -> tuple[Genes, ...]:
    """An amplitude and a phase for every joint.

    Femur and tibia count their phase from their coxa's, as a lag, so that a leg keeps its
    step while a mutation shifts it against the others.
    """
    return (
        Genes("amplitude", body.JOINTS, 0.0, amplitude_limit(frequency), mirror=0.0),
        Genes("phase", body.LEGS, -math.pi, math.pi, periodic=True, mirror=math.pi),
        Genes("lag", _FOLLOWERS, -math.pi, math.pi, periodic=True, mirror=0.0),
    )


def _oscillators(genomes: Genomes) -> tuple[_Floats, _Floats, _Floats]:
    """Amplitudes (population, 24), leg phases (population, 8), lags (population, 8, 3)."""
    amplitude, phase, lag = np.split(genomes, [24, 32], axis=1)
    lags = np.zeros((len(genomes), len(body.LEGS), 3))
    lags[:, :, 1:] = lag.reshape(-1, len(body.LEGS), 2)
    return amplitude, phase, lags


def _sine(genomes: Genomes, frequency: float) -> Angles:
    """θ(t) = A sin(2πft + φ), one frequency for all joints."""
    amplitude, phase, lags = _oscillators(genomes)
    phases = (phase[:, :, None] + lags).reshape(amplitude.shape)
    cycle = 2 * math.pi * frequency / body.FRAME_RATE * np.arange(body.FRAMES)
    # By the addition theorem: two products an angle and hardly a sine.
    angles: Angles = _column(amplitude * np.cos(phases)) * np.sin(cycle).astype(np.float32)
    angles += _column(amplitude * np.sin(phases)) * np.cos(cycle).astype(np.float32)
    return angles


def _column(values: _Floats) -> Angles:
    return values.astype(np.float32)[:, :, None]


_TETRAPOD = np.array([0.0, math.pi] * 2 + [math.pi, 0.0] * 2)
_COUPLING = 1.0  # 1/s, to each of the other legs
_GAIN = 10.0  # 1/s, how fast an amplitude settles


def _cpg(genomes: Genomes, frequency: float) -> Angles:
    """Coupled phase oscillators, one a leg, smooth from standing still.

    After Ijspeert (2008, Neural Networks 21), with every leg coupled to every other:
    φ̇ᵢ = 2πf + Σⱼ k sin(φⱼ − φᵢ − (ψⱼ − ψᵢ)), and a critically damped amplitude
    r̈ = a(a/4 (R − r) − ṙ), whose solution from rest is R(1 − e^(−at/2)(1 + at/2)).
    A joint's angle is r sin(φ + lag). The phases begin as those of an alternating
    tetrapod: were all the same, a gait whose sides alternate would be pulled both ways
    alike and never find its lags.
    """
    amplitude, phase, lags = _oscillators(genomes)
    seconds = np.arange(body.FRAMES) / body.FRAME_RATE
    # u = φ − 2πft − ψ obeys u̇ᵢ = k Σⱼ sin(uⱼ − uᵢ), which a mean field gives in O(legs).
    deviation = _TETRAPOD - phase
    phases = np.empty((len(genomes), len(body.LEGS), body.FRAMES))
    for frame in range(body.FRAMES):
        phases[:, :, frame] = deviation
        deviation = _runge_kutta(deviation, 1 / body.FRAME_RATE)
    phases += phase[:, :, None] + 2 * math.pi * frequency * seconds
    growth = 1 - np.exp(-_GAIN / 2 * seconds) * (1 + _GAIN / 2 * seconds)
    waves = np.sin(phases[:, :, None] + lags[..., None]).reshape(*amplitude.shape, -1)
    return limit_steps((growth * amplitude[:, :, None] * waves).astype(np.float32))


def _attraction(deviation: _Floats) -> _Floats:
    sine, cosine = np.sin(deviation), np.cos(deviation)
    pull: _Floats = _total(sine) * cosine - _total(cosine) * sine
    return _COUPLING * pull


def _total(values: _Floats) -> Any:
    return values.sum(axis=1, keepdims=True)


def _runge_kutta(state: _Floats, dt: float) -> _Floats:
    k1 = _attraction(state)
    k2 = _attraction(state + dt / 2 * k1)
    k3 = _attraction(state + dt / 2 * k2)
    k4 = _attraction(state + dt * k3)
    return state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def limit_steps(angles: Angles) -> Angles:
    """The course of a servo that follows `angles` with at most 5° a frame; exact where it can."""
    limited = angles.copy()
    step_limit = np.float32(body.STEP_LIMIT)
    for frame in range(1, angles.shape[2]):
        before = limited[:, :, frame - 1]
        limited[:, :, frame] = np.clip(
            angles[:, :, frame], before - step_limit, before + step_limit
        )
    return limited


ENCODINGS: dict[str, Encoding] = {
    "sine": Encoding(_oscillator_genes, _sine),
    "cpg": Encoding(_oscillator_genes, _cpg),
    "recurrence": Encoding(_recurrence_genes, _recurrence),
}
