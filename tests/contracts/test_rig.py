"""The rigs of the bundled bodies, against their skeletons moved into the trunk's frame."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gaitsim_robot.organism import Robot
from gaitsim_spider.organism import Spider
from gaitsim_walker.organism import Walker

CLOSE = 1e-6  # m


def spider_frames(body, motion, skeleton):
    corners = skeleton.segments[:, :4, 0]  # front left, front right, back right, back left
    forward, left = corners[:, 0] - corners[:, 3], corners[:, 0] - corners[:, 1]
    axes = [forward / 0.20, left / 0.14, np.cross(forward, left) / (0.20 * 0.14)]
    return corners.mean(axis=1), Rotation.from_matrix(np.stack(axes, axis=2))


def walker_frames(body, motion, skeleton):
    return motion["torso"][1], Rotation.from_euler("y", -motion["pitch"][1][:, None])


def robot_frames(body, motion, skeleton):
    turns = body.simulation.turn(motion["configuration"][1][:, 3:7])
    return skeleton.centre, Rotation.from_quat(turns[:, [1, 2, 3, 0]])


SHORT = {"duration": 1.0}


@pytest.mark.parametrize(
    ("kind", "options", "frames"),
    [
        (Spider, {}, spider_frames),
        (Spider, {"damage": ("L2 lost", "R1 femur stuck 20")}, spider_frames),
        (Walker, {"legs": 2, **SHORT}, walker_frames),
        (Walker, SHORT, walker_frames),
        (Robot, SHORT, robot_frames),
        (Robot, {"model": "hexapod", "encoding": "sine", **SHORT}, robot_frames),
        (Robot, {"model": "spider-physics", **SHORT}, robot_frames),
        (Robot, {"damage": ("L1 lost",), **SHORT}, robot_frames),
    ],
)
def test_a_rig_places_the_skeletons_points(kind, options, frames):
    body = kind(**options)
    genomes = body.genome_space().random(2, np.random.default_rng(1))
    motion = body.move(genomes)
    skeleton, rig = body.skeleton(motion, 1), body.rig()
    places, turns = frames(body, motion, skeleton)
    angles = motion["joint_positions"][1]

    def inside(points):
        """Points (frames, …, 3) of the world in the trunk's frame."""
        flat = points.reshape(len(points), -1, 3) - places[:, None]
        turned = np.stack([turn.inv().apply(one) for turn, one in zip(turns, flat, strict=True)])
        return turned.reshape(points.shape)

    placed = rig.place(angles)
    assert (rig.names, rig.foot_names) == (skeleton.names, skeleton.contact_names)
    assert rig.damaged == skeleton.damaged
    assert np.abs(placed.segments - inside(skeleton.segments)).max() < CLOSE
    assert np.abs(placed.feet - inside(skeleton.contacts)).max() < CLOSE
    assert [one.name for one in rig.solids] == [one.name for one in skeleton.solids]
    if skeleton.poses is None:
        return
    assert np.abs(placed.poses[..., :3] - inside(skeleton.poses[..., :3])).max() < CLOSE
    for solid in range(len(rig.solids)):
        turned = [
            Rotation.from_quat(one[:, solid, [4, 5, 6, 3]])
            for one in (placed.poses, skeleton.poses)
        ]
        assert (turned[0].inv() * turns.inv() * turned[1]).magnitude().max() < CLOSE
