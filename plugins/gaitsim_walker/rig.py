"""The walker as a tree of links."""

import numpy as np

from gaitsim.contracts import Link, Rig
from gaitsim.contracts.quaternions import turn_about_axis
from gaitsim_walker import body
from gaitsim_walker.body import LIMB, Plan

TRUNK = "torso"
DOWN = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -LIMB]])  # a thigh or shank in its own frame, m


def rig(plan: Plan) -> Rig:
    """Return the rig of a walker.

    Links turn about y. In its own frame, a thigh or shank hangs down.
    """
    links, names, ends, carriers = (
        [Link(TRUNK)],
        list(body.OUTLINE_NAMES),
        [*body.outline(plan)],
        [TRUNK] * 4,
    )
    for leg in plan.legs:
        thigh, shank, direction = f"{leg.name} thigh", f"{leg.name} shank", float(leg.knee)
        x, z = leg.hip
        bend = direction * body.BEND
        links += [
            Link(
                thigh,
                TRUNK,
                (x, 0.0, z),
                turn_about_axis(1, -bend),
                f"{leg.name} hip",
                (0.0, -1.0, 0.0),
            ),
            Link(
                shank,
                thigh,
                (0.0, 0.0, -LIMB),
                turn_about_axis(1, 2 * bend),
                f"{leg.name} knee",
                (0.0, direction, 0.0),
            ),
        ]
        names += [thigh, shank]
        carriers += [thigh, shank]
        ends += [DOWN, DOWN]
    return Rig(
        tuple(links),
        plan.joints,
        tuple(names),
        np.array(ends),
        tuple(carriers),
        np.tile(DOWN[1], (len(plan.legs), 1)),
        tuple(f"{leg.name} shank" for leg in plan.legs),
        tuple(leg.name for leg in plan.legs),
    )
