"""A reference for walking, in double precision with SciPy; it shares no code with the kernels."""

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation


def walk(feet, centre):
    """Return pose, stance, slip, margin and slope of one body, as in the spider's channels.

    Args:
        feet: feet in the body's frame, (frames, 8, 3) m.
        centre: centre of mass in the body's frame, (frames, 3) m.
    """
    feet, centre = feet.astype(float), centre.astype(float)
    middles, balances = (feet[1:] + feet[:-1]) / 2, (centre[1:] + centre[:-1]) / 2
    pose, intervals = [np.zeros(3)], []
    for middle, travel, balance in zip(middles, np.diff(feet, axis=0), balances, strict=True):
        normal, offset = resting_plane(middle, balance)
        down = middle @ normal - offset < 0.002
        turn, _ = Rotation.align_vectors([[0, 0, 1]], [normal])
        flat, step = turn.apply(middle)[:, :2], turn.apply(travel)[:, :2]
        twist, slid = rigid_motion(flat[down], step[down])
        heading = pose[-1][2] + twist[2] / 2
        cos, sin = np.cos(heading), np.sin(heading)
        forward = [cos * twist[0] - sin * twist[1], sin * twist[0] + cos * twist[1]]
        pose.append(pose[-1] + [*forward, twist[2]])
        sides = ConvexHull(flat[down]).equations
        margin = -(sides[:, :2] @ turn.apply(balance)[:2] + sides[:, 2]).max()
        intervals.append((down, slid, margin, np.arccos(normal[2])))
    return (np.array(pose), *map(np.array, zip(*intervals, strict=True)))


def resting_plane(points, balance):
    """Return the upward unit normal and the offset of the lower hull under `balance`."""
    facets = ConvexHull(points).equations
    below = facets[facets[:, 2] < -1e-9]
    heights = -(below[:, :2] @ balance[:2] + below[:, 3]) / below[:, 2]
    facet = below[np.argmax(heights)]  # the lower hull is the highest of its planes
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
