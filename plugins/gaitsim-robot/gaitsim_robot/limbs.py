"""Limbs of a robot: chains of joints from the trunk to parts that could touch the ground."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.anatomy import Floats, Side
from gaitsim_robot.chain import Chain, sliding
from gaitsim_robot.linkage import chain_to, joints_to, loops, motors, ties
from gaitsim_robot.shapes import RobotSurface, surfaces

Indices = NDArray[np.intp]

FINGERS = 0.35  # share of a limb's length; branches closer to its end are fingers or toes
HIP = 0.25  # share of a limb's length within which several joints form one hip
ANKLE = 0.3  # share of a limb's length, largest height of an ankle above a level sole
SAMPLES = 512  # poses that sample the reach of a limb


@dataclass(frozen=True, eq=False)
class Limb:
    """A limb in the robot's reference pose.

    Attributes:
        joints: driven joints from the hip to the foot, then those of other branches of a closed
            linkage, without joints shared with other limbs, then pulleys of tendons, (joints,).
        bodies: bodies of the foot and its toes, which touch the ground, (bodies,).
        parts: all bodies that only this limb moves, (bodies,).
        chain: chain from the hip to the tip, which is the middle of a ball.
        radius: radius of that ball, m; 0 for a point.
        foot: body of the tip.
        sole: extents of a level sole along x and y, (2,) m; 0 for a point foot.
        hip: anchor of the last joint of the hip, (3,) m.
        knee: index in `joints` of the first joint after the hip.
        length: largest distance between `hip` and the tip, m.
        wheels: driven joints of a wheel at the end, which do not belong to the leg.
    """

    joints: Indices
    bodies: Indices
    parts: Indices
    chain: Chain
    radius: float
    foot: int
    sole: Floats
    hip: Floats
    knee: int
    length: float
    wheels: tuple[int, ...] = ()

    @cached_property
    def weights(self) -> Floats:
        """Weights of position and orientation for `Chain.solve`, (6,)."""
        return self.chain.weights(bool(self.sole.any()))

    @cached_property
    def samples(self) -> Floats:
        """Angles that cover the limits, starting with the pose at zero, (samples, joints) rad."""
        lower, upper = self.chain.lower, self.chain.upper
        return np.vstack([self.chain.zero, lower + _halton(len(lower)) * (upper - lower)])

    @cached_property
    def tips(self) -> Floats:
        """Positions of the tip at `samples`, (samples, 3) m."""
        return self.chain.place(self.samples)


class Tree:
    """The tree of a robot's bodies in the pose of `data`; bodies welded together form a group."""

    def __init__(self, model: Any, data: Any) -> None:
        self.model, self.data = model, data
        self.surfaces: RobotSurface = surfaces(model)
        self.points = self.surfaces.place(data)
        self.weld = np.asarray(model.body_weldid, np.intp)
        self.motors = motors(model)
        self.loops = [around for _, _, around in loops(model)]
        self.ties = ties(model).values()
        self.parent = {
            int(group): int(self.weld[model.body_parentid[group]])
            for group in np.unique(self.weld)
            if group > 1
        }
        touching = set(self.weld[self.surfaces.bodies].tolist())
        kept: set[int] = set()
        for group in touching:
            kept.update(self._path(group))
        self.children = {
            group: sorted(child for child in kept if self.parent[child] == group)
            for group in (1, *kept)
        }

    def limbs(self) -> list[Limb]:
        """Return the limbs, in the order of their bodies."""
        ends: list[int] = []
        for child in self.children[1]:
            self._collect(child, ends)
        return self._create_limbs(ends)

    def limbs_to(self, bodies: list[int]) -> list[Limb]:
        """Return the limbs that end at given bodies."""
        return self._create_limbs([int(self.weld[body]) for body in bodies])

    def _create_limbs(self, ends: list[int]) -> list[Limb]:
        clusters = [self._cluster(end) for end in ends]
        legs = []
        for end, groups in zip(ends, clusters, strict=True):
            # Of the branches of a closed linkage, the one that reaches lowest has the foot.
            rivals = [one for one, other in zip(ends, clusters, strict=True) if groups & other]
            if len(groups) == len(self._path(end)) or end == min(rivals, key=self._lowest):
                legs.append((end, groups))
        shared = {
            group
            for i, (_, groups) in enumerate(legs)
            for _, others in legs[:i]
            for group in groups & others
        }
        limbs = [self._create_limb(groups - shared, end) for end, groups in legs]
        return [limb for limb in limbs if limb is not None]

    def _cluster(self, end: int) -> set[int]:
        """Return the groups of a limb: its path, and branches that closed linkages tie to it."""
        of_path = set(joints_to(self.model, self._body(end)))
        found = set(self._path(end))
        for around in self.loops:
            if around & of_path:
                bodies = self.model.jnt_bodyid[sorted(around)]
                found |= {int(self.weld[body]) for body in bodies}
        return found

    def _body(self, group: int) -> int:
        return int(np.flatnonzero(self.weld == group)[0])

    def _lowest(self, group: int) -> float:
        """Return the height of the lowest point of a group and of all below it, m."""
        points = self.surfaces.points_on(self._below(group))
        return float((self.points[points, 2] - self.surfaces.radius[points]).min(initial=np.inf))

    def _path(self, group: int) -> list[int]:
        """Return the groups from the trunk, exclusive, to a group, inclusive."""
        path: list[int] = []
        while group > 1:
            path.insert(0, group)
            group = self.parent[group]
        return path

    def _collect(self, group: int, ends: list[int]) -> None:
        children = self.children[group]
        if len(children) == 1:
            self._collect(children[0], ends)
        elif not children or self._depth(group) < FINGERS * (
            self._from_trunk(group) + self._depth(group)
        ):
            ends.append(group)
        else:
            for child in children:
                self._collect(child, ends)

    def _anchor(self, group: int) -> Floats:
        anchor: Floats = self.data.xanchor[self.model.body_jntadr[group]]
        return anchor

    def _from_trunk(self, group: int) -> float:
        path = self._path(group)
        anchors = np.array([self._anchor(one) for one in path])
        return float(np.linalg.norm(np.diff(anchors, axis=0), axis=1).sum())

    def _depth(self, group: int) -> float:
        """Return the length of the longest path from a group's anchor to a surface below, m."""
        anchor = self._anchor(group)
        deepest = [
            float(np.linalg.norm(self._anchor(child) - anchor)) + self._depth(child)
            for child in self.children[group]
        ]
        own = self.points[self.surfaces.points_on(np.flatnonzero(self.weld == group))]
        if len(own):
            deepest.append(float(np.linalg.norm(own - anchor, axis=1).max()))
        return max(deepest, default=0.0)

    def _below(self, group: int) -> Indices:
        """Return the bodies of a group and of all groups below it."""
        inside = [one for one in self.parent if group in self._path(one)]
        return np.flatnonzero(np.isin(self.weld, inside))

    def _create_limb(self, groups: set[int], end: int) -> Limb | None:
        model, data = self.model, self.data
        path = [group for group in self._path(end) if group in groups]
        inside = [
            joint
            for group in (*path, *sorted(groups - {*path}))
            for joint in range(
                model.body_jntadr[group], model.body_jntadr[group] + model.body_jntnum[group]
            )
        ]
        joints = [joint for joint in inside if joint in self.motors]
        pulleys = [tie.keys() - {*inside} for tie in self.ties if tie.keys() & {*inside}]
        joints += sorted(joint for some in pulleys if some <= self.motors for joint in some)
        foot = self._below(end)
        of_foot = self.surfaces.points_on(foot)
        if not joints or not len(of_foot):
            return None
        wheels: list[int] = []
        while len(joints) > 1 and self._is_wheel(joints[-1], of_foot):
            wheels.append(joints.pop())
        anchors = data.xanchor[joints]
        tip, radius, body, sole = self._tip(anchors, of_foot)
        segments = np.linalg.norm(np.diff(np.vstack([anchors, tip]), axis=0), axis=1)
        before = np.concatenate([[0.0], np.cumsum(segments)[:-1]])
        hip = int(np.flatnonzero(before <= HIP * segments.sum())[-1])
        chain = chain_to(model, data, joints, tip, body)
        parts = np.unique(np.concatenate([self._below(group) for group in groups]))
        return Limb(
            np.array(joints, np.intp), foot, parts, chain, radius, body, sole,
            anchors[hip].copy(), hip + 1, _farthest(chain, hip), tuple(wheels),
        )  # fmt: skip

    def _is_wheel(self, joint: int, of_foot: Indices) -> bool:
        """Return whether the foot is a wheel about this joint, with equal radius at all angles."""
        if sliding(self.model)[joint]:
            return False
        axis, anchor = self.data.xaxis[joint], self.data.xanchor[joint]
        lever = self.points[of_foot] - anchor
        across = lever - np.outer(lever @ axis, axis)
        side, other = np.linalg.svd(axis[None])[2][1:]  # perpendicular to the axis
        turns = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        normals = np.outer(np.cos(turns), side) + np.outer(np.sin(turns), other)
        reach = (across @ normals.T + self.surfaces.radius[of_foot][:, None]).max(axis=0)
        return bool(reach.min() > 0.8 * reach.max())

    def _tip(self, anchors: Floats, of_foot: Indices) -> tuple[Floats, float, int, Floats]:
        """Return the tip, the radius of its ball, its body, and the extents of its sole."""
        points, radius = self.points[of_foot], self.surfaces.radius[of_foot]
        bodies = self.surfaces.bodies[of_foot]
        ankle = anchors[-1]
        length = np.linalg.norm(np.diff(anchors, axis=0), axis=1).sum()
        far = np.linalg.norm(points - ankle, axis=1) + radius
        length += far.max()
        lows = points[:, 2] - radius
        level = lows < lows.min() + 0.02 * length
        extent = np.ptp(points[level, :2], axis=0)
        drop = ankle[2] - lows.min()
        hangs = anchors[0, 2] - lows.min() > 0.5 * length
        if hangs and 0 < drop < ANKLE * length and extent[0] > max(drop, 0.06 * length):
            middle = (points[level].max(axis=0) + points[level].min(axis=0)) / 2
            middle[2] = lows.min()
            lowest = int(np.argmin(lows))
            return middle, 0.0, int(bodies[lowest]), extent
        farthest = far > far.max() - 0.01 * length
        ball = int(np.argmax(far))
        tip = points[farthest & (bodies == bodies[ball])].mean(axis=0)
        return tip, float(radius[ball]), int(bodies[ball]), np.zeros(2)


def leg_order(limbs: Sequence[Limb], sides: Sequence[Side]) -> list[int]:
    """Return the indices of legs in the order L1 R1 L2 R2 …, middle legs last."""
    rank: dict[int, tuple[int, int, int]] = {}
    for column, side in enumerate(("left", "right", "middle")):
        members = [index for index, one in enumerate(sides) if one == side]
        members.sort(key=lambda index: -float(limbs[index].hip[0]))
        for row, index in enumerate(members):
            rank[index] = (side == "middle", row, column)
    return sorted(rank, key=rank.__getitem__)


def _farthest(chain: Chain, hip: int) -> float:
    """Return the largest distance between the tip and a joint's anchor, by coordinate ascent, m."""
    angles, joints = chain.zero.copy(), range(hip + 1, len(chain.zero))
    at = chain.anchors[hip]
    for _ in range(3):
        for joint in joints:
            tried = np.tile(angles, (65, 1))
            tried[:, joint] = np.linspace(chain.lower[joint], chain.upper[joint], 65)
            distance = np.linalg.norm(chain.place(tried) - at, axis=1)
            angles = tried[int(np.argmax(distance))]
    return float(np.linalg.norm(chain.place(angles) - at))


def _halton(columns: int) -> Floats:
    """Return points that fill the unit cube evenly, (SAMPLES, columns) (Halton 1960).

    The bits are those of `scipy.stats.qmc`, whose import takes longer than all else here.
    """
    bases = (base for base in count(2) if all(base % lower for lower in range(2, base)))
    points = np.zeros((SAMPLES, columns))
    for column, base in enumerate(islice(bases, columns)):
        index, digit = np.arange(1, SAMPLES + 1), 1.0 / base
        while 1.0 - digit < 1.0:
            points[:, column] += index % base * digit
            index, digit = index // base, digit / base
    return points
