"""A robot to draw."""

from itertools import pairwise
from typing import Any

import numpy as np

from gaitsim.contracts import Motion, Skeleton
from gaitsim_robot.world import World


def skeleton(world: World, motion: Motion, individual: int) -> Skeleton:
    """Return the segments from joint to joint of each leg of one individual, over time."""
    import mujoco

    model: Any = world.model
    data = mujoco.MjData(model)
    configuration = motion["configuration"][individual]
    chains = [[*(model.joint(name).bodyid[0] for name in leg.joints)] for leg in world.anatomy.legs]
    feet = motion["foot_positions"][individual]
    offset = np.array([*world.start[1:3], 0.0])
    segments = []
    for frame, positions in enumerate(configuration):
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        drawn: list[tuple[Any, Any]] = []
        for leg, chain in enumerate(chains):
            points = [data.xpos[1], *(data.xpos[body] for body in chain)]
            points = [*(np.array(point) - offset for point in points), feet[frame, leg]]
            drawn += pairwise(points)
        segments.append(drawn)
    names = tuple(
        f"{leg.name} {part}" for leg in world.anatomy.legs for part in ("hip", *leg.joints)
    )
    return Skeleton(
        np.array(segments),
        names,
        motion.frame_rate,
        contacts=feet,
        touching=motion["stance"][individual],
        contact_names=tuple(leg.name for leg in world.anatomy.legs),
        centre=motion["torso"][individual],
    )
