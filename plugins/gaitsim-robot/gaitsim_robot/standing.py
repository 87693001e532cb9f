"""The standing pose: feet on level ground, bent knees, and the centre of mass above the feet."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.plugin.toolkit import matmul, principal_axes
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.limbs import Limb
from gaitsim_robot.linkage import Linkage
from gaitsim_robot.shapes import surfaces

# Positions of a foot relative to its hip, outward and down, in leg lengths; best first.
UPRIGHT = (
    (0.0, 0.82),
    (0.0, 0.88),
    (0.0, 0.93),
    (0.0, 0.75),
    (0.15, 0.8),
    (0.0, 0.65),
    (0.3, 0.65),
)
# Eleven humanoids fall equally often with these knees as with those above, walk farther, and need
# less torque.
BIPED = ((0.0, 0.88), (0.0, 0.93), (0.0, 0.82), (0.0, 0.75), (0.0, 0.65))
SPRAWLED = ((0.65, 0.45), (0.6, 0.6), (0.75, 0.35), (0.5, 0.3), (0.8, 0.45), (0.4, 0.7), (0.8, 0.2))
STRAIGHT = 0.96  # share of its length beyond which a leg counts as straight
UNEVEN = 0.03  # leg lengths, largest difference in height between two feet on the ground
CLEARANCE = 0.1  # leg lengths, smallest height of the trunk, its arms and its head
GRAZE = 0.01  # leg lengths, smallest height of knees, and of all parts in a given pose; a link next
# to a foot, such as a shin that ends at the ankle, may come as close to the ground as it likes
MARGIN = 0.2  # share of the support, distance of the centre of mass from its edges in found poses
LEVEL = 0.03  # rad, largest angle between a sole and the ground
MIRRORED = 0.02  # leg lengths, largest distance of a joint's axis from that of the mirrored leg
PARALLEL = 0.99  # smallest cosine of the angle between such axes
STARTS = 24  # initial poses from which inverse kinematics starts


class Stand:
    """Check whether a robot stands in a pose, and search for a standing pose.

    Args:
        model: MuJoCo's model.
        limbs: the legs.
        partners: for each leg, the index of the leg that mirrors it, or -1.
        mirrored: whether `search` gives each exactly mirrored pair of legs mirrored angles.
    """

    def __init__(
        self, model: Any, limbs: Sequence[Limb], partners: Sequence[int], mirrored: bool = True
    ) -> None:
        import mujoco

        self.model, self.limbs, self.partners = model, list(limbs), partners
        self.unpaired = limbs
        # The first leg of each pair whose angles the second leg mirrors, by the second leg's index.
        self.images: dict[int, int] = {}
        for second, first in enumerate(partners if mirrored else ()):
            if 0 <= first < second == partners[first]:
                pair = _with_common_limits(limbs[first], limbs[second])
                if pair:
                    self.limbs[first], self.limbs[second] = pair
                    self.images[second] = first
        self.data = mujoco.MjData(model)
        self.surfaces = surfaces(model)
        self.reach = float(np.mean([limb.length for limb in limbs]))
        self.of_feet = [self.surfaces.points_on(limb.bodies) for limb in limbs]
        feet = np.concatenate(self.of_feet)
        self.others = np.setdiff1d(np.arange(len(self.surfaces.geoms)), feet)
        parts = np.concatenate([limb.parts for limb in limbs])
        self.of_trunk = ~np.isin(self.surfaces.bodies[self.others], parts)
        shins = [self._above_foot(limb) for limb in limbs]
        self.of_shins = np.isin(model.body_weldid[self.surfaces.bodies[self.others]], shins)

    def pose(self, qpos: Floats) -> Floats:
        """Pose the robot, with its linkages closed, and return its surface, (points, 3) m."""
        import mujoco

        self.data.qpos[:] = qpos
        for limb in self.limbs:
            if isinstance(limb.chain, Linkage):
                address = limb.chain.addresses
                self.data.qpos[address] = limb.chain.dependents(self._angles(limb, qpos))
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        return self.surfaces.place(self.data)

    def on_ground(self, qpos: Floats) -> Floats:
        """Return the pose with its lowest foot on the ground z = 0."""
        points = self.pose(qpos)
        grounded: Floats = self.data.qpos.copy()
        grounded[2] -= min(self._lowest_heights(points))
        return grounded

    def contacts(self, qpos: Floats) -> list[Floats]:
        """Return the points of each foot that touch the ground, (points, 3) m."""
        points = self.pose(qpos)
        touching = []
        for of_foot in self.of_feet:
            low = points[of_foot] - [0, 0, 1] * self.surfaces.radius[of_foot][:, None]
            touching.append(low[low[:, 2] < low[:, 2].min() + 0.01 * self.reach])
        return touching

    def problem(self, qpos: Floats, bent: bool) -> str:
        """Return why the robot does not stand in a pose, or ''.

        Args:
            qpos: the pose, (nq,).
            bent: whether to require bent knees, level soles and larger margins.
        """
        points = self.pose(qpos)
        lows = self._lowest_heights(points)
        if max(lows) - min(lows) > UNEVEN * self.reach:
            return f"the heights of its feet differ by {1000 * (max(lows) - min(lows)):.0f} mm"
        heights = points[self.others, 2] - self.surfaces.radius[self.others] - min(lows)
        least = np.where(self.of_trunk & bent, CLEARANCE, GRAZE) * self.reach
        least[self.of_shins] = 0.0
        if len(heights) and (heights < least).any():
            return self._too_low(heights, least)
        for limb in self.limbs:
            tip = limb.chain.place(self._angles(limb, qpos))
            straight = np.linalg.norm(tip - self.data.xanchor[limb.joints[limb.knee - 1]])
            if bent and limb.knee < len(limb.joints) and straight > STRAIGHT * limb.length:
                return f"the leg that ends at {self.model.body(limb.foot).name!r} is straight"
            if bent and limb.sole.any() and self._tilt(limb, qpos) > LEVEL:
                return f"the sole of {self.model.body(limb.foot).name!r} is not level"
        return self._balance(qpos, MARGIN if bent else 0.0)

    def _above_foot(self, limb: Limb) -> int:
        """Return the group of the nearest link above a foot that has a surface."""
        group = int(self.model.body_weldid[self.model.body_parentid[limb.bodies[0]]])
        while group > 1 and not (self.model.body_weldid[self.surfaces.bodies] == group).any():
            group = int(self.model.body_weldid[self.model.body_parentid[group]])
        return group if group > 1 else limb.foot

    def _too_low(self, heights: Floats, least: Floats) -> str:
        """Return which link is too close to the ground, given heights of `others`, (points,) m."""
        lowest = int(np.argmin(heights - least))
        link = self.model.body(self.surfaces.bodies[self.others[lowest]]).name
        height = float(heights[lowest])
        if height < 0:
            return f"the link {link!r} reaches {_distance(-height)} below the feet"
        return (
            f"the link {link!r} is {_distance(height)} above the ground, and must be at least "
            f"{_distance(least[lowest])} above it"
        )

    def _tilt(self, limb: Limb, qpos: Floats) -> float:
        """Return the angle between a sole and the ground, rad."""
        turn = limb.chain.rotation(self._angles(limb, qpos))
        return float(np.arccos(np.clip(turn[2, 2], -1, 1)))

    def _balance(self, qpos: Floats, margin: float) -> str:
        contacts = np.vstack(self.contacts(qpos))[:, :2]
        middle = (contacts.min(axis=0) + contacts.max(axis=0)) / 2
        contacts = middle + (1 - 2 * margin) * (contacts - middle)
        self.pose(qpos)
        centre = self.data.subtree_com[1][:2]
        outside = _distance_outside(contacts, centre)
        if outside > 0.02 * self.reach:
            return f"its centre of mass is {1000 * outside:.0f} mm outside the support of its feet"
        return ""

    def search(self, rest: Floats) -> tuple[Floats | None, str]:
        """Return the best standing pose and '', or None and the reason why there is none.

        Args:
            rest: pose that joints outside the legs keep and that legs stay close to, (nq,).
        """
        problem = ""
        is_pair = list(self.partners) == [1, 0]
        sprawls, upright = not is_pair and self._is_sprawled(), BIPED if is_pair else UPRIGHT
        for outward, down in (*SPRAWLED, *upright) if sprawls else (*upright, *SPRAWLED):
            found = self._attempt(rest, outward, down)
            reason = self.problem(found, True)
            if not reason:
                return self.on_ground(found), ""
            problem = problem or reason
        return None, problem

    def can_bend(self) -> bool:
        """Return whether any leg has enough joints to bend while its sole remains level."""
        return any(len(limb.joints) > 2 or not limb.sole.any() for limb in self.limbs)

    def _is_sprawled(self) -> bool:
        """Return whether the legs reach sideways in their reference pose."""
        sideways = [
            (limb.chain.tip[1] - limb.hip[1]) * np.sign(limb.hip[1]) / limb.length
            for limb in self.limbs
        ]
        return bool(np.median(sideways) > 0.3)

    def _attempt(self, rest: Floats, outward: float, down: float) -> Floats:
        ground = max(limb.hip[2] - down * limb.length for limb in self.limbs)
        targets = [self._target(limb, outward, ground) for limb in self.limbs]
        qpos = rest.copy()
        for index, (limb, target) in enumerate(zip(self.limbs, targets, strict=True)):
            if 0 <= self.partners[index] < index:
                angles = self._mirrored(index, self.partners[index], qpos)
                if index not in self.images:
                    angles = limb.chain.solve(target, angles, limb.chain.zero, limb.weights)
            else:
                angles = self._best_angles(limb, target, rest)
            qpos[self._addresses(limb)] = angles
        for _ in range(4):
            qpos = self._correct(qpos, targets, ground)
        return qpos

    def _correct(self, qpos: Floats, targets: list[Floats], ground: float) -> Floats:
        """Return a pose with the feet moved to the ground and below the centre of mass."""
        points = self.pose(qpos)
        lows = self._lowest_heights(points)
        centre = self.data.subtree_com[1] - np.mean(
            [(foot.min(axis=0) + foot.max(axis=0)) / 2 for foot in self.contacts(qpos)], axis=0
        )
        self.pose(qpos)
        better = qpos.copy()
        for index, (limb, low) in enumerate(zip(self.limbs, lows, strict=True)):
            if index in self.images:
                better[self._addresses(limb)] = self._mirrored(index, self.images[index], better)
                continue
            aside = 0.0 if index in self.images.values() else centre[1]
            targets[index] = targets[index] + [centre[0], aside, ground - low]
            angles = self._angles(limb, qpos)
            better[self._addresses(limb)] = limb.chain.solve(
                targets[index], angles, limb.chain.zero, limb.weights
            )
        return better

    def _mirrored(self, index: int, first: int, qpos: Floats) -> Floats:
        """Return the angles of a leg that mirror those of the leg `first` in a pose."""
        limb = self.limbs[first]
        return mirror_angles(limb.chain, self.limbs[index].chain, self._angles(limb, qpos))

    def _target(self, limb: Limb, outward: float, ground: float) -> Floats:
        direction = limb.chain.tip[:2] - limb.hip[:2]
        if not outward and abs(direction[1]) < 0.25 * limb.length:
            # The leg hangs in its own plane, which need not contain the hip.
            return np.array([limb.hip[0], limb.chain.tip[1], ground + limb.radius])
        if np.linalg.norm(direction) < 0.2 * limb.length:
            direction = limb.hip[:2] - np.mean([one.hip[:2] for one in self.limbs], axis=0)
        norm = np.linalg.norm(direction)
        across = direction / norm * outward * limb.length if norm else direction
        return np.array([*(limb.hip[:2] + across), ground + limb.radius])

    def _best_angles(self, limb: Limb, target: Floats, rest: Floats) -> Floats:
        """Return the angles that move a foot to a target with the knee on the better side."""
        chain, width = limb.chain, np.maximum(limb.chain.upper - limb.chain.lower, 1e-6)
        near = np.linalg.norm((limb.tips - target) * limb.weights[:3], axis=1) / limb.length
        away = (((limb.samples - self._angles(limb, rest)) / width) ** 2).sum(axis=1)
        starts = limb.samples[np.argsort(near + 0.2 * away, kind="stable")[:STARTS]]
        starts = np.vstack([chain.zero, starts])
        angles = chain.solve(
            np.broadcast_to(target, (len(starts), 3)), starts, chain.zero, limb.weights, 40
        )
        error = (chain.place(angles) - target) * limb.weights[:3] / limb.length
        margin = np.minimum(angles - chain.lower, chain.upper - angles) / width
        cost = 100 * np.linalg.norm(error, axis=1)
        cost += (np.maximum(0.05 - margin, 0) * 10).sum(axis=1)
        cost += 0.5 * (((angles - self._angles(limb, rest)) / width) ** 2).mean(axis=1)
        cost += [self._awkwardness(limb, one, rest) for one in angles]
        best: Floats = angles[int(np.argmin(cost))]
        return best

    def _awkwardness(self, limb: Limb, angles: Floats, rest: Floats) -> float:
        """Return a cost for parts of the leg below its foot and for a knee on the worse side."""
        qpos = rest.copy()
        qpos[self._addresses(limb)] = angles
        points = self.pose(qpos)
        tip = limb.chain.place(angles)[2] - limb.radius + qpos[2]
        parts = self.surfaces.points_on(limb.parts)
        low = (points[parts, 2] - self.surfaces.radius[parts]).min(initial=tip)
        knees = self.data.xanchor[limb.joints] - self.data.xanchor[limb.joints[0]]
        forward = knees[:, 0].mean() / limb.length * (-1 if len(self.limbs) == 2 else 1)
        up = knees[:, 2].mean() / limb.length
        return float(20 * max(0.0, tip - low) / limb.length + 0.1 * forward - 0.1 * up)

    def _lowest_heights(self, points: Floats) -> list[float]:
        return [
            float((points[of_foot, 2] - self.surfaces.radius[of_foot]).min())
            for of_foot in self.of_feet
        ]

    def _addresses(self, limb: Limb) -> Any:
        return self.model.jnt_qposadr[limb.joints]

    def _angles(self, limb: Limb, qpos: Floats) -> Floats:
        angles: Floats = qpos[self._addresses(limb)]
        return angles


def _distance(metres: float) -> str:
    return f"{metres:.2g} m" if metres >= 1 else f"{1000 * metres:.2g} mm"


def mirror_angles(chain: Any, other: Any, angles: Floats) -> Floats:
    """Return the angles of `other` that mirror given angles of `chain`, clipped to the limits."""
    count = min(len(chain.zero), len(other.zero))
    signs = (chain.mirrored_axes[:count] * other.axes[:count]).sum(axis=1)
    image = other.zero.copy()
    image[:count] += np.sign(signs) * (angles - chain.zero)[:count]
    within: Floats = np.clip(image, other.lower, other.upper)
    return within


def _with_common_limits(limb: Limb, other: Limb) -> tuple[Limb, Limb] | None:
    """Return two legs with the limits that they share, or None if they do not mirror each other."""
    chain, image = limb.chain, other.chain
    axes = chain.mirrored_axes
    cosines = (axes * image.axes).sum(axis=1)
    middle = (limb.hip + other.hip)[1] / 2
    apart = (np.vstack([chain.anchors, chain.tip]) - [0, middle, 0]) * [1, -1, 1]
    apart -= np.vstack([image.anchors, image.tip]) - [0, middle, 0]
    apart[:-1] -= (apart[:-1] * axes).sum(axis=1, keepdims=True) * axes  # any anchor on an axis
    far = np.linalg.norm(apart, axis=1).max() > MIRRORED * limb.length
    signs = np.sign(cosines)
    ends = chain.zero + signs * (np.array([image.lower, image.upper]) - image.zero)
    lower = np.maximum(chain.lower, ends.min(axis=0))
    upper = np.minimum(chain.upper, ends.max(axis=0))
    if far or (np.abs(cosines) < PARALLEL).any() or (lower > upper).any():
        return None
    ends = np.sort(image.zero + signs * (np.array([lower, upper]) - chain.zero), axis=0)
    ends = np.clip(ends, image.lower, image.upper)
    return (
        replace(limb, chain=replace(chain, lower=lower, upper=upper)),
        replace(other, chain=replace(image, lower=ends[0], upper=ends[1])),
    )


def _distance_outside(points: Floats, place: Floats) -> float:
    """Return the distance of a place from the convex hull of points, m; 0 inside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
        if (hull.equations @ [*place, 1.0]).max() <= 0:
            return 0.0
        corners = points[hull.vertices]
    except QhullError:  # fewer than three points, or all on a line
        spread = points - points.mean(axis=0)
        variances, axes = principal_axes(matmul(spread.T, spread))
        along = matmul(spread, axes[int(np.argmax(variances)), :, None])[:, 0]
        corners = points[[int(np.argmin(along)), int(np.argmax(along))]]
    starts, ends = corners, np.roll(corners, -1, axis=0)
    edges = ends - starts
    squared = np.maximum((edges**2).sum(axis=1), 1e-18)
    share = np.clip(((place - starts) * edges).sum(axis=1) / squared, 0, 1)
    return float(np.linalg.norm(starts + share[:, None] * edges - place, axis=1).min())
