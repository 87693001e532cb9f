"""The recurrence, sine and cpg encodings, which turn genomes into joint angles."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes
from gaitsim.plugin.toolkit import (
    GeneGroup,
    Oscillators,
    amplitude_limit,
    limit_steps,
    split_genomes,
)
from gaitsim_spider import body

Angles = NDArray[np.float32]
"""(population, 24, frames) joint angles, radians from the pose at rest."""

_OSCILLATORS = Oscillators(
    np.repeat(np.arange(len(body.LEGS)), len(body.SEGMENTS)),
    body.FRAMES,
    body.FRAME_RATE,
    np.float32,
)
_TETRAPOD = np.array([0.0, math.pi] * 2 + [math.pi, 0.0] * 2)
_FOLLOWERS = tuple(joint for joint in body.JOINTS if not joint.endswith("coxa"))


@dataclass(frozen=True)
class SpiderEncoding:
    """The gene groups for a frequency, Hz, and a symmetry, and the decoder of genomes."""

    groups: Callable[[float, bool], tuple[GeneGroup, ...]]
    decode: Callable[[Genomes, float, tuple[GeneGroup, ...]], Angles]

    def angles(self, genomes: Genomes, frequency: float, symmetric: bool) -> Angles:
        """Return joint angles; if symmetric, the right legs lag the left legs by half a stride."""
        return self.decode(genomes, frequency, self.groups(frequency, symmetric))


def largest_amplitude(frequency: float) -> float:
    """Return the largest amplitude, rad, that both joint limits allow; 23.9 °·Hz / frequency."""
    speed_limit = body.STEP_LIMIT * body.FRAME_RATE
    return float(amplitude_limit(frequency, body.ANGLE_LIMIT, speed_limit))


@cache
def _recurrence_groups(_frequency: float, _symmetric: bool) -> tuple[GeneGroup, ...]:
    """Return weight and bias of each joint; the first half of a genome controls the left legs."""
    return tuple(
        GeneGroup(name, (joint,), -largest, largest)
        for joint in body.JOINTS
        for name, largest in (("weight", 4.0), ("bias", 0.2))
    )


def _recurrence(genomes: Genomes, _frequency: float, _groups: tuple[GeneGroup, ...]) -> Angles:
    """Iterate θ ← clip(θ + clip(w θ + b, ±5°), ±30°) from rest, once per frame.

    This is a first-order map of one number: every orbit ends at a fixed point or alternates
    between two values, so the only lasting motion is a flip-flop at half the frame rate.
    """
    from gaitsim_spider.waves import recur

    angles = np.empty((len(genomes), len(body.JOINTS), body.FRAMES), dtype=np.float32)
    recur(
        np.ascontiguousarray(genomes, dtype=np.float32),
        np.float32(body.STEP_LIMIT),
        np.float32(body.ANGLE_LIMIT),
        angles,
    )
    return angles


@cache
def _oscillator_groups(frequency: float, symmetric: bool) -> tuple[GeneGroup, ...]:
    """Return an amplitude per joint, a phase per leg, and a lag per femur and tibia.

    The lags of femur and tibia are relative to the phase of their leg, so that a mutation of that
    phase shifts the whole step of the leg against the others.
    """
    groups = (
        GeneGroup("amplitude", body.JOINTS, 0.0, largest_amplitude(frequency)),
        GeneGroup("phase", body.LEGS, -math.pi, math.pi, periodic=True),
        GeneGroup("lag", _FOLLOWERS, -math.pi, math.pi, periodic=True),
    )
    if not symmetric:
        return groups
    return tuple(group.halved(math.pi if group.name == "phase" else 0.0) for group in groups)


def tetrapod(frequency: float, symmetric: bool) -> NDArray[np.float64]:
    """Return an alternating tetrapod made by hand, as a genome (genes,) of 'sine' and 'cpg'.

    Coxae and tibiae swing as far as they may, and femora lift the feet as they swing forward. The
    tibiae lengthen the stride: those of the front legs reach out as the coxae swing forward, those
    of the hind legs as they swing back. Those of the middle legs move an eighth of a stride closer
    to the lift.
    """
    side = len(body.LEGS) // 2
    lift, eighth = math.pi / 2, math.pi / 4
    reach = [0.0, -eighth, eighth - math.pi, math.pi]
    amplitude = np.tile([1.0, 0.6, 1.0], (side, 1))
    lag = np.stack([np.full(side, lift), reach], axis=1)
    amplitude *= largest_amplitude(frequency)
    copies = 1 if symmetric else 2
    return np.concatenate(
        [
            np.tile(amplitude.ravel(), copies),
            _TETRAPOD[: side * copies],
            np.tile(lag.ravel(), copies),
        ]
    )


def _values(genomes: Genomes, groups: tuple[GeneGroup, ...]) -> tuple[Any, Any, Any]:
    """Return amplitudes (population, 24), leg phases (population, 8), lags (population, 24)."""
    amplitude, phase, follower_lag = split_genomes(genomes, groups)
    lag = np.zeros((len(genomes), len(body.LEGS), len(body.SEGMENTS)))
    lag[:, :, 1:] = follower_lag.reshape(len(genomes), len(body.LEGS), -1)
    return amplitude, phase, lag.reshape(amplitude.shape)


def _sine(genomes: Genomes, frequency: float, groups: tuple[GeneGroup, ...]) -> Angles:
    """Compute θ = A sin(2πft + φ + λ), equal to `Oscillators.sine` and twenty times as fast."""
    from gaitsim_spider.waves import sum_waves, unit_waves

    angles = np.empty((len(genomes), len(body.JOINTS), body.FRAMES), dtype=np.float32)
    waves = unit_waves(2 * math.pi * frequency / body.FRAME_RATE, body.FRAMES)
    amplitude, phase, lag = _values(genomes, groups)
    # Contiguous, as the kernel is compiled for each layout of an array.
    values = np.ascontiguousarray(amplitude), np.ascontiguousarray(phase), lag
    sum_waves(*waves, *values, angles)
    return angles


def _cpg(genomes: Genomes, frequency: float, groups: tuple[GeneGroup, ...]) -> Angles:
    """Couple every leg to every other leg, with the initial phases of an alternating tetrapod."""
    angles = _OSCILLATORS.cpg(*_values(genomes, groups), frequency, start=_TETRAPOD)
    return limit_steps(angles, body.STEP_LIMIT)


ENCODINGS: dict[str, SpiderEncoding] = {
    "sine": SpiderEncoding(_oscillator_groups, _sine),
    "cpg": SpiderEncoding(_oscillator_groups, _cpg),
    "recurrence": SpiderEncoding(_recurrence_groups, _recurrence),
}
