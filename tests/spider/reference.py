"""A reference for walking, in double precision with SciPy; it shares no code with the kernels."""

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

RADIUS = 0.008  # m, of a foot


def walk(feet, centre, lean=(0.0, 0.0)):
    """Return pose, stance, slip, margin and slope of one body, as in the spider's channels.

    Args:
        feet: feet in the body's frame, (frames, 8, 3) m.
        centre: centre of mass in the body's frame, (frames, 3) m.
        lean: gravity along the ground, relative to gravity into the ground.
    """
    feet, centre = feet.astype(float), centre.astype(float)
    middles, balances = (feet[1:] + feet[:-1]) / 2, (centre[1:] + centre[:-1]) / 2
    pose, intervals = [np.zeros(3)], []
    for middle, travel, balance in zip(middles, np.diff(feet, axis=0), balances, strict=True):
        twist = np.zeros(3)
        for _ in range(5 if any(lean) else 1):  # until the heading fits the feet on the ground
            heading = pose[-1][2] + twist[2] / 2
            cos, sin = np.cos(heading), np.sin(heading)
            aside = np.array([[cos, sin], [-sin, cos]]) @ lean
            normal, offset = resting_plane(middle, balance, aside)
            down = middle @ normal - offset < 0.002
            turn, _ = Rotation.align_vectors([[0, 0, 1]], [normal])
            flat, step = turn.apply(middle)[:, :2], turn.apply(travel)[:, :2]
            twist, slid = rigid_motion(flat[down], step[down])
        heading = pose[-1][2] + twist[2] / 2
        cos, sin = np.cos(heading), np.sin(heading)
        forward = [cos * twist[0] - sin * twist[1], sin * twist[0] + cos * twist[1]]
        pose.append(pose[-1] + [*forward, twist[2]])
        sides = ConvexHull(flat[down]).equations
        support = turn.apply(balance)[:2] + (balance @ normal - offset + RADIUS) * aside
        margin = -(sides[:, :2] @ support + sides[:, 2]).max()
        intervals.append((down, slid, margin, np.arccos(normal[2])))
    return (np.array(pose), *map(np.array, zip(*intervals, strict=True)))


def resting_plane(points, balance, lean=(0.0, 0.0)):
    """Return the upward unit normal and the offset of the lower hull under `balance`.

    The line of gravity leaves the hull of the points of contact, which are below the feet.
    """
    facets, along = ConvexHull(points).equations, np.array([*lean, -1.0])
    below = facets[facets[:, :3] @ along > 1e-9]
    start = balance + np.array([0.0, 0.0, RADIUS])
    depths = -(below[:, :3] @ start + below[:, 3]) / (below[:, :3] @ along)
    facet = below[np.argmin(depths)]
    return -facet[:3], facet[3]


def rigid_motion(flat, step):
    """Return the displacement and turn that best keep feet in place, and their mean slide."""
    zeros, ones = np.zeros(len(flat)), np.ones(len(flat))
    along = np.stack([ones, zeros, -flat[:, 1]], axis=1)
    across = np.stack([zeros, ones, flat[:, 0]], axis=1)
    rows = np.concatenate([along, across])
    travel = np.concatenate([step[:, 0], step[:, 1]])
    twist = np.linalg.lstsq(rows, -travel)[0]
    return twist, np.linalg.norm((travel + rows @ twist).reshape(2, -1), axis=0).mean()
