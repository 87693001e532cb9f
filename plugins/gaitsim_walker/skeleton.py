"""The walker as segments to draw."""

import math

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim_walker import body
from gaitsim_walker.body import Floats
from gaitsim_walker.surroundings import Surroundings


def skeleton(surroundings: Surroundings, motion: Motion, individual: int) -> Skeleton:
    """Return the outline of the torso, and thigh and shank of each leg, in the plane y = 0.

    Args:
        surroundings: body and ground; their slope rotates the result, so that gravity points down.
        motion: motion of the population.
        individual: index of the individual to draw.
    """
    plan, ground, slope = surroundings.plan, surroundings.ground, surroundings.slope
    level = not slope and not any(ground.z)
    profile = body.to_3d(np.column_stack([ground.x, ground.z]))
    position, pitch = motion["torso"][individual], motion["pitch"][individual]
    corners = body.outline(plan)[..., [0, 2]]
    cos, sin = np.cos(pitch)[:, None, None], np.sin(pitch)[:, None, None]
    edges = np.stack(
        [
            cos * corners[..., 0] - sin * corners[..., 1],
            sin * corners[..., 0] + cos * corners[..., 1],
        ],
        axis=-1,
    )
    edges += position[:, None, None, [0, 2]]
    where = body.leg_points(plan, position[:, [0, 2]], pitch, motion["joint_positions"][individual])
    limbs = np.stack([where[:, :, :-1], where[:, :, 1:]], axis=3)
    segments = np.concatenate([edges, limbs.reshape(len(pitch), -1, 2, 2)], axis=1)
    names = [f"{leg.name} {part}" for leg in plan.legs for part in ("thigh", "shank")]
    return Skeleton(
        _rotated(body.to_3d(segments), slope),
        (*body.OUTLINE_NAMES, *names),
        motion.frame_rate,
        contacts=_rotated(motion["foot_positions"][individual], slope),
        touching=motion["stance"][individual],
        contact_names=tuple(leg.name for leg in plan.legs),
        centre=_rotated(position, slope),
        ground=None if level else _rotated(profile, slope)[:, [0, 2]],
    )


def _rotated(points: Floats, slope: float) -> Floats:
    """Rotate points, (…, 3) m, uphill about the start by a slope in rad."""
    cos, sin = math.cos(slope), math.sin(slope)
    turned = points.copy()
    turned[..., 0] = cos * points[..., 0] - sin * points[..., 2]
    turned[..., 2] = sin * points[..., 0] + cos * points[..., 2]
    return turned
