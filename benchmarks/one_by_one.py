"""The body of the preset spider-recurrence in plain NumPy, one individual at a time.

Programs built on lists of individuals typically look like this: one object per individual, and a
loop over them in Python. Arrays hold the legs or joints, and the frames if the model allows it.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.experiment import Experiment
from gaitsim_spider import body
from gaitsim_spider.classic import SpiderClassic


class OneByOne:
    """Evaluator that scores genomes as the preset does."""

    def __init__(self, experiment: Experiment) -> None:
        assert isinstance(experiment.fitness, SpiderClassic)
        self._fitness = experiment.fitness

    def score(self, genome: NDArray[np.float64]) -> float:
        """Return the score of one genome, (48,)."""
        angles = _recur(genome.astype(np.float32))
        return self._score(angles, *_feet(angles))

    def _score(self, angles: Any, x: Any, z: Any) -> float:
        f = self._fitness
        travel = np.abs(np.diff(x, axis=0)).sum(axis=0)
        height = z + (body.STANDING_HEIGHT - body.FOOT_RADIUS)
        supports = np.abs(height) <= f.stance_band
        count = np.maximum(supports.sum(axis=1), 1)
        mean = (supports * height).sum(axis=1) / count
        variance = (supports * height**2).sum(axis=1) / count - mean**2
        crossed = np.abs(angles[:, ::3]) - math.radians(f.crossing_angle)
        return float(
            f.movement_scalar * travel.mean()
            + f.band_reward_scalar * supports.mean()
            - f.low_movement_penalty_scalar * (travel < f.low_movement).mean()
            - f.penetration_scalar * np.maximum(-height, 0).mean()
            - f.variance_scalar * np.maximum(variance, 0).mean()
            - f.overlapping_legs_fitness_scalar * np.maximum(crossed, 0).mean()
            - f.angle_change_scalar * (np.diff(angles, axis=0) ** 2).mean()
        )


def _recur(genome: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the joint angles of a genome, (frames, 24)."""
    weight, bias = genome.reshape(-1, 2).T
    step_limit, angle_limit = np.float32(body.STEP_LIMIT), np.float32(body.ANGLE_LIMIT)
    angles = np.zeros((body.FRAMES, len(body.JOINTS)), np.float32)
    for frame in range(1, body.FRAMES):
        now = angles[frame - 1]
        step = np.clip(weight * now + bias, -step_limit, step_limit)
        angles[frame] = np.clip(now + step, -angle_limit, angle_limit)
    return angles


def _feet(angles: NDArray[np.float32]) -> tuple[Any, Any]:
    """Return the x and z coordinates of the feet, each (frames, 8)."""
    coxa, femur, tibia = angles[:, ::3], angles[:, 1::3], angles[:, 2::3]
    femur_pitch = body.FEMUR_PITCH + femur
    tibia_pitch = body.TIBIA_PITCH + femur + tibia
    reach = body.COXA + body.FEMUR * np.cos(femur_pitch) + body.TIBIA * np.cos(tibia_pitch)
    x = body.HIP_X + reach * np.sin(body.AZIMUTH + coxa)
    return x, body.FEMUR * np.sin(femur_pitch) + body.TIBIA * np.sin(tibia_pitch)
