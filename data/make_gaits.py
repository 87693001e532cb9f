"""Makes the reference gaits in data/gaits: run `python data/make_gaits.py`.

Joint angles of the spider, (300 frames, 24 joints) float32 radians from the pose at rest, at
30 Hz. SOURCES.md says where each pattern comes from.
"""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FRAMES, FRAME_RATE = 300, 30.0
LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
JOINTS = tuple(f"{leg} {joint}" for leg in LEGS for joint in ("coxa", "femur", "tibia"))
STEP, LIMIT = math.radians(5.0), math.radians(30.0)
FOLDER = Path(__file__).parent / "gaits"

# The spider's legs, as docs/spider.md has them: metres, and radians at rest.
COXA, FEMUR, TIBIA = 0.03, 0.08, 0.12
AZIMUTH = np.radians([45.0, 15.0, -15.0, -45.0] * 2)
FEMUR_PITCH, TIBIA_PITCH = math.radians(30.0), math.radians(-80.0)
REACH = COXA + FEMUR * math.cos(FEMUR_PITCH) + TIBIA * math.cos(TIBIA_PITCH)
DEPTH = FEMUR * math.sin(FEMUR_PITCH) + TIBIA * math.sin(TIBIA_PITCH)

Angles = NDArray[np.float64]
Phases = Sequence[float | None]


def stepping(phases: Phases, frequency: float, duty: float, stroke: float, lift: float) -> Angles:
    """Feet that carry the body straight ahead without slipping, and swing back lifted.

    A foot goes back by `stroke` in stance, so the body makes stroke × frequency / duty
    metres a second.

    Args:
        phases: when each leg comes down, cycles; None holds it up all the time.
        frequency: strides a second, Hz.
        duty: share of the stride on the ground.
        stroke: how far a foot moves along the body in stance, metres.
        lift: height of the foot in the middle of the swing, metres.
    """
    angles = np.zeros((FRAMES, len(LEGS), 3))
    seconds = np.arange(FRAMES) / FRAME_RATE
    for leg, phase in enumerate(phases):
        if phase is None:
            angles[:, leg, 1] = LIMIT
            continue
        stride = (frequency * seconds - phase) % 1.0
        swing = np.clip((stride - duty) / (1 - duty), 0, 1)
        ahead = stroke * np.where(stride < duty, 0.5 - stride / duty, swing - 0.5)
        angles[:, leg] = reaching(AZIMUTH[leg], ahead, lift * np.sin(np.pi * swing))
    return angles.reshape(FRAMES, -1)


def reaching(azimuth: float, ahead: Angles, up: Angles) -> Angles:
    """Joint angles, (frames, 3), that put a foot so far ahead of and above its place at rest."""
    forward = REACH * math.sin(azimuth) + ahead
    sideways = REACH * math.cos(azimuth)
    out, down = np.hypot(forward, sideways) - COXA, DEPTH + up
    bend = (out**2 + down**2 - FEMUR**2 - TIBIA**2) / (2 * FEMUR * TIBIA)
    knee = -np.arccos(bend)
    femur = np.arctan2(down, out) - np.arctan2(TIBIA * np.sin(knee), FEMUR + TIBIA * bend)
    return np.stack(
        [
            np.arctan2(forward, sideways) - azimuth,
            femur - FEMUR_PITCH,
            knee - (TIBIA_PITCH - FEMUR_PITCH),
        ],
        axis=1,
    )


def alternating_tetrapod() -> Angles:
    """R4 L3 R2 L1 against L4 R3 L2 R1 (Barth 2002)."""
    return stepping([0, 0.5, 0, 0.5, 0.5, 0, 0.5, 0], 1.25, 0.5, 0.05, 0.018)


def alternating_tripod() -> Angles:
    """L1 R2 L4 against R1 L2 R4, as insects do with six legs; the third pair is held up."""
    return stepping([0, 0.5, None, 0, 0.5, 0, None, 0.5], 1.25, 0.5, 0.05, 0.018)


def wave() -> Angles:
    """One leg after the other, from back to front on the left, then on the right."""
    return stepping(
        [3 / 8, 2 / 8, 1 / 8, 0, 7 / 8, 6 / 8, 5 / 8, 4 / 8], 30 / 80, 7 / 8, 0.05, 0.016
    )


def ripple() -> Angles:
    """Two legs at a time, each a quarter of a stride after the one behind it."""
    return stepping([3 / 4, 2 / 4, 1 / 4, 0, 1 / 4, 0, 3 / 4, 2 / 4], 0.75, 3 / 4, 0.05, 0.015)


def standing() -> Angles:
    """The pose at rest."""
    return np.zeros((FRAMES, len(JOINTS)))


def flip_flop() -> Angles:
    """What the recurrence encoding ends in: every joint flips between two angles each frame.

    θ ← clip(θ + clip(w θ + b, ±5°), ±30°) with w = −2.2, and a bias that differs by leg.
    """
    bias = 0.02 * np.repeat([1, -1, -1, 1, -1, 1, 1, -1], 3)
    angles = np.zeros((FRAMES, len(JOINTS)))
    for frame in range(1, FRAMES):
        now = angles[frame - 1]
        angles[frame] = np.clip(now + np.clip(-2.2 * now + bias, -STEP, STEP), -LIMIT, LIMIT)
    return angles


def noise() -> Angles:
    """Angles at random, which the joints follow as fast as they may."""
    wanted = np.random.default_rng(0).uniform(-LIMIT, LIMIT, (FRAMES, len(JOINTS)))
    angles = np.zeros_like(wanted)
    for frame in range(1, FRAMES):
        step = np.clip(wanted[frame] - angles[frame - 1], -STEP, STEP)
        angles[frame] = angles[frame - 1] + step
    return angles


GAITS: dict[str, Callable[[], Angles]] = {
    "alternating-tetrapod": alternating_tetrapod,
    "alternating-tripod": alternating_tripod,
    "wave": wave,
    "ripple": ripple,
    "standing": standing,
    "flip-flop": flip_flop,
    "noise": noise,
}


def main() -> None:
    """Write every gait."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in GAITS.items():
        angles = make()
        if np.abs(np.diff(angles, axis=0)).max() > STEP + 1e-9:
            raise SystemExit(f"{name} turns a joint by more than 5° a frame")
        np.savez_compressed(
            FOLDER / f"{name}.npz",
            joint_angles=angles.astype(np.float32),
            joint_names=np.array(JOINTS),
            frame_rate=FRAME_RATE,
        )


if __name__ == "__main__":
    main()
