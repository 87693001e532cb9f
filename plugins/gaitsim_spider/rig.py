"""The spider as a tree of links."""

import math

import numpy as np

from gaitsim.contracts import Link, Rig
from gaitsim.contracts.quaternions import turn_about_axis
from gaitsim_spider import body
from gaitsim_spider.damage import Anatomy

TRUNK = "body"


def rig(anatomy: Anatomy) -> Rig:
    """Return the rig of the body without its lost legs.

    A coxa turns about the vertical, femur and tibia about the leg's sideways axis. The x axis of
    each link's frame points outward along the link.
    """
    links, names, ends, carriers = (
        [Link(TRUNK)],
        list(body.OUTLINE_NAMES),
        [*body.OUTLINE],
        [TRUNK] * 4,
    )
    feet, foot_links = [], []
    for leg, lost in zip(range(len(body.LEGS)), anatomy.lost, strict=True):
        side, hip = (
            float(body.SIDE[leg]),
            (float(body.HIP_X[leg]), float(body.SIDE[leg]) * body.HIP_Y, 0.0),
        )
        if lost:
            feet.append(hip)
            foot_links.append(TRUNK)
            continue
        coxa, femur, tibia = body.LEG_JOINTS[body.LEGS[leg]]
        outward = side * (math.pi / 2 - float(body.AZIMUTH[leg]))
        up = (0.0, -1.0, 0.0)
        links += [
            Link(coxa, TRUNK, hip, turn_about_axis(2, outward), coxa, (0.0, 0.0, -side)),
            Link(
                femur, coxa, (body.COXA, 0.0, 0.0), turn_about_axis(1, -body.FEMUR_PITCH), femur, up
            ),
            Link(
                tibia,
                femur,
                (body.FEMUR, 0.0, 0.0),
                turn_about_axis(1, body.FEMUR_PITCH - body.TIBIA_PITCH),
                tibia,
                up,
            ),
        ]
        for name, length in ((coxa, body.COXA), (femur, body.FEMUR), (tibia, body.TIBIA)):
            names.append(name)
            ends.append(np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]]))
            carriers.append(name)
        feet.append((body.TIBIA, 0.0, 0.0))
        foot_links.append(tibia)
    return Rig(
        tuple(links),
        body.JOINTS,
        tuple(names),
        np.array(ends),
        tuple(carriers),
        np.array(feet),
        tuple(foot_links),
        body.LEGS,
        damaged=anatomy.damaged,
    )
