"""Perturb joint angles: servos that lag or are updated rarely, and exchanged sides."""

import numpy as np
from numpy.typing import NDArray

Angles = NDArray[np.float64]
"""Joint angles over time, (frames, joints), radians."""


def apply_lag(angles: Angles, frames: float) -> Angles:
    """Filter joint angles with a first-order lag with a time constant of `frames` frames."""
    followed = angles.copy()
    share = 1 - np.exp(-1 / frames)
    for frame in range(1, len(angles)):
        followed[frame] = followed[frame - 1] + share * (angles[frame] - followed[frame - 1])
    return followed


def interpolate_every_second(angles: Angles) -> Angles:
    """Replace every second frame of joint angles with the mean of its neighbours."""
    result = angles.copy()
    between = result[1:-1:2]
    result[1:-1:2] = (angles[: len(between) * 2 : 2] + angles[2 : len(between) * 2 + 1 : 2]) / 2
    return result


def mirrored_joints(joints: tuple[str, ...]) -> list[int] | None:
    """Return the index of each joint's partner on the other side; None if the names have no sides.

    'L1 coxa' and 'R1 coxa' are partners, as are 'left knee' and 'right knee'. A positive angle is
    assumed to have the same meaning on both sides, such as forward or up. A joint without a side
    is its own partner.
    """
    found = []
    for joint in joints:
        other = _partner(joint)
        if other is not None and other not in joints:
            return None
        found.append(joints.index(other if other is not None else joint))
    return found if any(index != own for own, index in enumerate(found)) else None


def _partner(joint: str) -> str | None:
    for one, other in (("left", "right"), ("Left", "Right")):
        for here, there in ((one, other), (other, one)):
            if here in joint:
                return joint.replace(here, there, 1)
    if joint[:1] in ("L", "R") and (joint[1:2].isdigit() or joint[1:2] in (" ", "_", "-")):
        return ("R" if joint[0] == "L" else "L") + joint[1:]
    return None
