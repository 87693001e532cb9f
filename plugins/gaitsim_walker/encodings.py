"""The walker's encodings, `sine` and `cpg`, which turn genomes into joint angles over time."""

import math
from dataclasses import replace

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.encoding import GeneGroup, Oscillators, split_genomes
from gaitsim_walker.body import FRAME_RATE, Floats, Plan

SLOWEST = 0.5  # Hz, lower bound of the frequency gene
_DEGREE = math.pi / 180


def groups(plan: Plan, alternating: bool, fastest: float) -> tuple[GeneGroup, ...]:
    """Return the gene groups: six with one gene per leg, and the frequency.

    In an alternating gait, only the near legs have genes.
    """
    legs = tuple(leg.name for leg in plan.legs)
    by_leg: tuple[GeneGroup, ...] = (
        GeneGroup("swing", legs, 0.0, 35 * _DEGREE),
        GeneGroup("lean", legs, -15 * _DEGREE, 15 * _DEGREE),
        GeneGroup("bend", legs, 0.0, 40 * _DEGREE),
        GeneGroup("crouch", legs, -20 * _DEGREE, 20 * _DEGREE),
        GeneGroup("phase", legs, -math.pi, math.pi, periodic=True),
        GeneGroup("lag", legs, -math.pi, math.pi, periodic=True),
    )
    if alternating:
        by_leg = tuple(_near_legs(group) for group in by_leg)
    return (*by_leg, GeneGroup("frequency", ("",), SLOWEST, fastest))


def _near_legs(group: GeneGroup) -> GeneGroup:
    near = group.halved(math.pi if group.name == "phase" else 0.0)
    return replace(near, parts=tuple(leg.removeprefix("near").strip() for leg in near.parts))


def commands(
    plan: Plan, genomes: Genomes, genes: tuple[GeneGroup, ...], encoding: str, frames: int
) -> Floats:
    """Return the commands to the servos, (population, frames, joints) rad, within the limits.

    A leg swings about its hip by lean + swing · sin(2πft + φ), and its knee bends by crouch +
    bend · sin(2πft + φ + lag). The hip compensates for half of the knee's bend, so that bending
    lifts the foot without moving it forward or back.

    `sine` moves at full amplitude from the start. `cpg` starts from a standing pose with the
    phases of a trot; its oscillators are coupled to a leading one.
    """
    swing, lean, bend, crouch, phase, lag, frequency = split_genomes(genomes, genes)
    oscillators = Oscillators(np.repeat(np.arange(len(plan.legs)), 2), frames, FRAME_RATE)
    amplitude, lags = _by_joint(swing, bend), _by_joint(np.zeros_like(lag), lag)
    if encoding == "cpg":
        angles = oscillators.cpg(
            amplitude,
            phase,
            lags,
            frequency[:, 0],
            start=_trot(len(plan.legs)),
            coupling="leader",
            strength=COUPLING,
        )
    else:
        angles = oscillators.sine(amplitude, phase, lags, frequency[:, 0])
    angles += _by_joint(lean, crouch)[:, :, None]
    knees = np.array([float(leg.knee) for leg in plan.legs])
    angles[:, 0::2] += knees[:, None] * angles[:, 1::2] / 2
    return np.clip(angles.swapaxes(1, 2), -plan.limits, plan.limits)


COUPLING = 4.0  # 1/s, coupling to the leading oscillator


def _by_joint(hips: Floats, knees: Floats) -> Floats:
    """Interleave two arrays (population, legs) into (population, joints), hip before knee."""
    return np.stack([hips, knees], axis=2).reshape(len(hips), -1)


def _trot(legs: int) -> Floats:
    """Return the phases of a trot, or of two alternating legs, (legs,) rad."""
    return np.array([0.0, math.pi] if legs == 2 else [0.0, math.pi, math.pi, 0.0])
