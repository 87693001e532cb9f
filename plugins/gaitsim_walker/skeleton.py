"""The walker as segments to draw."""

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim_walker import body
from gaitsim_walker.body import Plan
from gaitsim_walker.ground import Ground


def skeleton(plan: Plan, ground: Ground | None, motion: Motion, individual: int) -> Skeleton:
    """Return the outline of the torso, and thigh and shank of each leg, in the plane y = 0.

    Args:
        plan: of the body.
        ground: to draw; None where it is flat.
        motion: of the population.
        individual: index of the one to draw.
    """
    position, pitch = motion["torso"][individual], motion["pitch"][individual]
    half_x, half_z = plan.half
    corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * [half_x, half_z]
    cos, sin = np.cos(pitch)[:, None], np.sin(pitch)[:, None]
    outline = np.stack(
        [
            cos * corners[:, 0] - sin * corners[:, 1],
            sin * corners[:, 0] + cos * corners[:, 1],
        ],
        axis=-1,
    )
    outline += position[:, None, [0, 2]]
    where = body.points(plan, position[:, [0, 2]], pitch, motion["joint_positions"][individual])
    limbs = np.stack([where[:, :, :-1], where[:, :, 1:]], axis=3)
    edges = np.stack([outline, np.roll(outline, -1, axis=1)], axis=2)
    segments = np.concatenate([edges, limbs.reshape(len(pitch), -1, 2, 2)], axis=1)
    names = [f"{leg.name} {part}" for leg in plan.legs for part in ("thigh", "shank")]
    return Skeleton(
        body.in_space(segments),
        ("front", "bottom", "back", "top", *names),
        motion.frame_rate,
        contacts=motion["foot_positions"][individual],
        touching=motion["stance"][individual],
        contact_names=tuple(leg.name for leg in plan.legs),
        centre=position,
        ground=None if ground is None else np.column_stack([ground.x, ground.z]),
    )
