"""How a genome becomes the course of the joint angles: the sine and cpg encodings."""

import math
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import RealSpace
from gaitsim_walker.body import Floats, Plan

FRAME_RATE = 60.0  # Hz, of the commands to the servos and of what is recorded
SLOWEST = 0.5  # Hz, of the gene for the frequency


@dataclass(frozen=True)
class Genes:
    """One kind of gene that each leg has."""

    what: str
    lower: float
    upper: float
    periodic: bool = False


_DEGREE = math.pi / 180
GENES = (
    Genes("swing", 0.0, 35 * _DEGREE),
    Genes("lean", -15 * _DEGREE, 15 * _DEGREE),
    Genes("bend", 0.0, 40 * _DEGREE),
    Genes("crouch", -20 * _DEGREE, 20 * _DEGREE),
    Genes("phase", -math.pi, math.pi, periodic=True),
    Genes("lag", -math.pi, math.pi, periodic=True),
)


def space(plan: Plan, alternating: bool, fastest: float) -> RealSpace:
    """Six genes a leg, of the near ones alone in an alternating gait, and the frequency."""
    legs = [leg.name for leg in plan.legs]
    if alternating:
        legs = [name.removeprefix("near").strip() for name in legs[: len(legs) // 2]]
    rows = [(genes, f"{leg} {genes.what}".strip()) for genes in GENES for leg in legs]
    return RealSpace(
        lower=np.array([*(genes.lower for genes, _ in rows), SLOWEST]),
        upper=np.array([*(genes.upper for genes, _ in rows), fastest]),
        labels=(*(label for _, label in rows), "frequency"),
        periodic=np.array([*(genes.periodic for genes, _ in rows), False]),
    )


def commands(plan: Plan, genome: Floats, encoding: str, alternating: bool, frames: int) -> Floats:
    """What the servos of one walker are told, (frames, joints) rad, held to the limits.

    A leg swings about its hip by lean + swing · sin(2πft + φ) and bends by crouch + bend ·
    sin(2πft + φ + lag), each of which turns the thigh back by half, so that bending lifts the
    foot and moves it neither forward nor back.

    `sine`: at full swing from the start.

    `cpg`: phase oscillators after Ijspeert (2008, Neural Networks 21), each coupled to a
    leading one, φ̇ = 2πf + k sin(2πft + ψ − φ), with ψ the phase gene. From u₀ off its phase an
    oscillator finds it as tan(u/2) = tan(u₀/2) e^(−kt), so nothing is integrated. Amplitudes
    grow from rest as R(1 − e^(−at/2)(1 + at/2)), the critically damped solution. The
    phases begin as those of a trot.
    """
    # One genome at a time, so that all arrays have one shape whoever else is moved.
    each = genome[:-1].reshape(len(GENES), -1)
    if alternating:
        each = np.concatenate([each, each], axis=1)
        each[4, each.shape[1] // 2 :] += math.pi
    swing, lean, bend, crouch, phase, lag = each
    seconds = np.arange(frames)[:, None] / FRAME_RATE
    phases = 2 * math.pi * genome[-1] * seconds + phase
    growth = np.ones_like(seconds)
    if encoding == "cpg":
        away = np.mod(_trot(len(phase)) - phase + math.pi, 2 * math.pi) - math.pi
        phases = phases + 2 * np.arctan(np.tan(away / 2) * np.exp(-COUPLING * seconds))
        growth = 1 - np.exp(-GAIN / 2 * seconds) * (1 + GAIN / 2 * seconds)
    angles = np.empty((frames, 2 * len(phase)))
    angles[:, 1::2] = crouch + growth * bend * np.sin(phases + lag)
    knees = np.array([leg.knee for leg in plan.legs])
    angles[:, 0::2] = lean + growth * swing * np.sin(phases) + knees * angles[:, 1::2] / 2
    return np.clip(angles, -plan.limits, plan.limits)


COUPLING = 4.0  # 1/s, to the leading oscillator
GAIN = 10.0  # 1/s, how fast an amplitude settles


def _trot(legs: int) -> Floats:
    """Phases of a trot, and of two legs in turn."""
    return np.array([0.0, math.pi] if legs == 2 else [0.0, math.pi, math.pi, 0.0])
