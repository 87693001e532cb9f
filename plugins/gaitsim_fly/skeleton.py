"""The fly's skeleton: segments to draw."""

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim.portable import matmul
from gaitsim_fly import body


def skeleton(
    motion: Motion, individual: int, size: tuple[float, float, float], span: float, chord: float
) -> Skeleton:
    """Return body and wings in the world frame, in the first trial.

    Args:
        motion: motion of the population.
        individual: index of the individual to draw.
        size: length, width and height of the body, m.
        span: span of a wing, m.
        chord: chord of a wing, m.
    """
    position, rotation, angles = (
        motion[name][individual, :, 0] for name in ("position", "rotation", "wing_angles")
    )
    pose = matmul(body.translation(position), body.rotation(rotation))  # M = T · R
    edges = body.cuboid(*size)
    parts = [body.transform(pose, np.broadcast_to(edges.reshape(-1, 3), (len(pose), 24, 3)))]
    for side, own in ((1, angles[:, :3]), (-1, angles[:, 3:])):
        corners = body.wing_points(side, span, chord)
        outline = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).reshape(-1, 3)
        hinged = matmul(pose, body.wing_matrix(own, side, size[1] / 2))
        parts.append(body.transform(hinged, np.broadcast_to(outline, (len(pose), 6, 3))))
    segments = np.concatenate(parts, axis=1).reshape(len(pose), -1, 2, 3)
    names = [f"body edge {number}" for number in range(1, 13)]
    names += [
        f"{side} wing {edge}"
        for side in ("left", "right")
        for edge in ("leading edge", "far edge", "trailing edge")
    ]
    return Skeleton(segments, tuple(names), motion.frame_rate, centre=position)
