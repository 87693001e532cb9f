"""Legs whose driven joints move others: closed linkages, coupled joints, and tendons."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import cos, matmul, sin
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.chain import (
    ITERATIONS,
    Chain,
    improved,
    jacobian,
    leg_chain,
    multiply,
    pose_data,
    sliding,
    turn_to,
    turned_about,
)

Indices = NDArray[np.intp]
CLOSED = 30.0  # weight of an open linkage, × that of an error of the tip
SETTLING = 15  # iterations that find the angles of dependent joints


@dataclass(frozen=True, eq=False)
class Linkage(Chain):
    """A leg with dependent joints, whose angles follow from those of its driven joints.

    The fields of `Chain` are those of the driven joints. The joints below are the driven and the
    dependent ones, parents first.

    Attributes:
        carriers: for each joint, whether each joint moves it, (joints, joints); the diagonal is
            true.
        every: anchors and axes of all joints in the pose `zero`, 2 × (joints, 3).
        limits: smallest and largest angles of all joints, 2 × (joints,) rad.
        every_slides: whether each of all joints slides, (joints,).
        start: angles of all joints in the pose `zero`, (joints,) rad.
        driven: indices of the driven joints.
        dependent: indices of the dependent joints.
        holder: index of the joint that carries the tip.
        pins: pairs of points that coincide: index of the joint that carries each, −1 for the
            trunk, (pins, 2), and the points in the pose `zero`, (pins, 2, 3) m.
        ties: matrix A and vector b of linear couplings by tendons A · angles = b, (ties, joints)
            and (ties,), each followed by the balance of the springs that share a tendon.
        couplings: follower, leader, and the coefficients c of follower = Σ cᵢ leaderⁱ, with angles
            relative to `origin`.
        origin: angles of the initial pose, (joints,) rad.
        addresses: indices of the dependent joints in a pose of MuJoCo's.
    """

    carriers: NDArray[np.bool_]
    every: tuple[Floats, Floats]
    limits: tuple[Floats, Floats]
    every_slides: NDArray[np.bool_]
    start: Floats
    driven: Indices
    dependent: Indices
    holder: int
    pins: tuple[Indices, Floats]
    ties: tuple[Floats, Floats]
    couplings: tuple[tuple[int, int, Floats], ...]
    origin: Floats
    addresses: Indices

    def solve(
        self, targets: Floats, start: Floats, hold: Floats, weights: Floats,
        iterations: int = ITERATIONS,
    ) -> Floats:  # fmt: skip
        orientation = self._pose(hold - self.zero)[1]
        start = np.broadcast_to(start, (*targets.shape[:-1], len(self.zero)))
        free = np.arange(len(self.start))
        found = self._minimise(
            self.complete(start), free, iterations, targets, orientation, weights
        )
        return np.clip(found[..., self.driven], self.lower, self.upper)

    def complete(self, angles: Floats) -> Floats:
        """Return the angles of all joints, (…, joints) rad, for those of the driven ones."""
        whole = np.broadcast_to(self.start, (*angles.shape[:-1], len(self.start))).copy()
        whole[..., self.driven] = angles
        return self._minimise(whole, self.dependent, SETTLING)

    def dependents(self, angles: Floats) -> Floats:
        """Return the angles of the dependent joints for those of the driven ones."""
        return self.complete(angles)[..., self.dependent]

    def _pose(self, turned: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        frames = self._frames(self.complete(turned + self.zero))
        tip, rotation = self._at(frames, self.holder, self.tip), frames[0][..., self.holder, :, :]
        return tip, rotation, frames[2][..., self.driven, :], frames[3][..., self.driven, :]

    def _minimise(
        self, angles: Floats, free: Indices, iterations: int, targets: Floats | None = None,
        orientation: Floats | None = None, weights: Floats | None = None,
    ) -> Floats:  # fmt: skip
        """Change free joints to close the linkage and, with targets, to move the tip there."""
        lower, upper = self.limits[0][free], self.limits[1][free]
        for _ in range(iterations):
            frames = self._frames(angles)
            error, slope = self._gaps(frames, angles)
            if targets is not None and orientation is not None and weights is not None:
                rows = np.flatnonzero(weights)
                tip = self._at(frames, self.holder, self.tip)
                rotation = frames[0][..., self.holder, :, :]
                off = np.concatenate([targets - tip, turn_to(rotation, orientation)], axis=-1)
                moves = jacobian(tip, *frames[2:], self.every_slides) * self.carriers[self.holder]
                error = np.concatenate([(off * weights)[..., rows], CLOSED * error], axis=-1)
                slope = np.concatenate(
                    [(moves * weights[:, None])[..., rows, :], CLOSED * slope], axis=-2
                )
            angles = angles.copy()
            angles[..., free] = improved(
                angles[..., free], error, slope[..., free], lower, upper, self.length
            )
        return angles

    def _frames(self, angles: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the rotation and shift of the frame that each joint moves, anchors and axes."""
        turned = angles - self.start
        sine, versine = sin(turned), 1 - cos(turned)
        rotations = np.empty((*turned.shape, 3, 3))
        shifts, anchors, axes = (np.empty((*turned.shape, 3)) for _ in range(3))
        for joint, (anchor, axis) in enumerate(zip(*self.every, strict=True)):
            parents = np.flatnonzero(self.carriers[joint, :joint])
            if len(parents):
                before, moved = rotations[..., parents[-1], :, :], shifts[..., parents[-1], :]
            else:
                before, moved = (
                    np.broadcast_to(np.eye(3), (*rotations.shape[:-3], 3, 3)),
                    np.zeros(3),
                )
            anchors[..., joint, :] = multiply(before, anchor) + moved
            axes[..., joint, :] = multiply(before, axis)
            if self.every_slides[joint]:
                rotations[..., joint, :, :] = before
                shifts[..., joint, :] = moved + axes[..., joint, :] * turned[..., [joint]]
                continue
            turn = turned_about(axis, sine[..., joint], versine[..., joint])
            rotations[..., joint, :, :] = matmul(before, turn)
            shifts[..., joint, :] = anchors[..., joint, :] - multiply(
                rotations[..., joint, :, :], anchor
            )
        return rotations, shifts, anchors, axes

    def _at(self, frames: Sequence[Floats], joint: int, point: Floats) -> Floats:
        """Return where a point is that a joint, or the trunk, carries."""
        if joint < 0:
            return np.broadcast_to(point, (*frames[1].shape[:-2], 3))
        return multiply(frames[0][..., joint, :, :], point) + frames[1][..., joint, :]

    def _motion(self, frames: Sequence[Floats], joint: int, place: Floats) -> Floats:
        """Return the derivatives of a carried point by all joints, (…, 3, joints) m/rad."""
        if joint < 0:
            return np.zeros((*place.shape, len(self.start)))
        moved = jacobian(place, frames[2], frames[3], self.every_slides)[..., :3, :]
        return np.asarray(moved * self.carriers[joint])

    def _gaps(self, frames: Sequence[Floats], angles: Floats) -> tuple[Floats, Floats]:
        """Return what is missing for a closed linkage, (…, rows) m, and its derivatives."""
        gaps: list[Floats] = []
        slopes: list[Floats] = []
        for (one, other), (near, far) in zip(*self.pins, strict=True):
            here, there = self._at(frames, one, near), self._at(frames, other, far)
            gaps.append(there - here)
            slopes.append(self._motion(frames, one, here) - self._motion(frames, other, there))
        size = self.length
        matrix, wanted = self.ties
        if len(matrix):
            gaps.append(size * (wanted - multiply(matrix, angles)))
            slopes.append(np.broadcast_to(size * matrix, (*angles.shape[:-1], *matrix.shape)))
        for follower, leader, coefficients in self.couplings:
            x, y = (angles[..., joint] - self.origin[joint] for joint in (leader, follower))
            power, value, rate = np.ones_like(x), np.zeros_like(x), np.zeros_like(x)
            for n, factor in enumerate(coefficients):
                value += factor * power
                if n + 1 < len(coefficients):
                    rate += (n + 1) * coefficients[n + 1] * power
                power = power * x
            gaps.append(size * (value - y)[..., None])
            slope = np.zeros((*x.shape, 1, len(self.start)))
            slope[..., 0, follower], slope[..., 0, leader] = size, -size * rate
            slopes.append(slope)
        return np.concatenate(gaps, axis=-1), np.concatenate(slopes, axis=-2)


def standing_chains(model: Any, anatomy: Anatomy) -> tuple[Chain, ...]:
    """Return the chains of the legs in the standing pose, with their tips at the contacts."""
    data = pose_data(model, anatomy.stance)
    chains = []
    for leg in anatomy.legs:
        foot = model.body(leg.foot).id
        tip = data.xpos[foot] + multiply(data.xmat[foot].reshape(3, 3), np.asarray(leg.point))
        joints = np.array([model.joint(name).id for name in leg.joints])
        chains.append(chain_to(model, data, joints, tip, foot))
    return tuple(chains)


def chain_to(model: Any, data: Any, joints: Any, tip: Floats, foot: int) -> Chain:
    """Return the chain of a leg in the pose of `data`: a linkage if other joints depend on its own.

    Other passive joints, such as those with springs, keep their angles.

    Args:
        model: MuJoCo's model.
        data: the pose.
        joints: the driven joints of the leg.
        tip: position of the tip, (3,) m.
        foot: body of the tip.
    """
    plain = leg_chain(model, data, joints, tip)
    own = set(map(int, joints))
    pins, couplings, taut, moving = _constraints(model, own, joints_to(model, foot))
    if not (pins or couplings or taut):
        return plain
    order = np.array(sorted(own | moving), np.intp)
    paths = [joints_to(model, int(body)) for body in model.jnt_bodyid[order]]
    carriers = np.array(
        [
            [one <= joint and one in path for one in order]
            for joint, path in zip(order, paths, strict=True)
        ]
    )

    holders, points = [], []
    for sites, weld in pins.items():
        # Three points that coincide are a weld.
        for away in 0.3 * plain.length * np.eye(4, 3, -1)[: 3 if weld else 1]:
            holders.append(
                [_last(order, joints_to(model, int(model.site_bodyid[one]))) for one in sites]
            )
            points.append(
                [data.site_xpos[one] + data.site_xmat[one].reshape(3, 3) @ away for one in sites]
            )
    low, high = model.jnt_range[order].T.copy()
    free = ~model.jnt_limited[order].astype(bool)
    low[free], high[free] = -np.inf, np.inf
    at = {int(joint): index for index, joint in enumerate(order)}
    driven = np.array([at[int(joint)] for joint in joints], np.intp)
    low[driven], high[driven] = plain.lower, plain.upper
    dependent = np.setdiff1d(np.arange(len(order)), driven)
    return Linkage(
        plain.anchors, plain.axes, tip, plain.zero, plain.lower, plain.upper, plain.slides,
        carriers=carriers,
        every=(data.xanchor[order].copy(), data.xaxis[order].copy()),
        limits=(low, high),
        every_slides=sliding(model)[order],
        start=data.qpos[model.jnt_qposadr[order]].copy(),
        driven=driven,
        dependent=dependent,
        holder=_last(order, joints_to(model, foot)),
        pins=(np.array(holders, np.intp).reshape(-1, 2), np.array(points).reshape(-1, 2, 3)),
        ties=_ties(model, order, dependent, taut),
        couplings=tuple((at[one], at[other], factors) for one, other, factors in couplings),
        origin=model.qpos0[model.jnt_qposadr[order]].copy(),
        addresses=model.jnt_qposadr[order[dependent]],
    )  # fmt: skip


def joints_to(model: Any, body: int) -> list[int]:
    """Return the joints between the trunk and a body, the innermost first."""
    found: list[int] = []
    while body > 1:
        first = int(model.body_jntadr[body])
        found = [*range(first, first + int(model.body_jntnum[body])), *found]
        body = int(model.body_parentid[body])
    return found


def motors(model: Any) -> set[int]:
    """Return the joints with a motor: those that the robot's text states, or else all."""
    import mujoco

    pulled = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON
    joints = set(model.actuator_trnid[~pulled, 0].tolist())
    tendons = model.actuator_trnid[pulled, 0].tolist()
    joints |= {model.joint(model.tendon(one).name).id for one in tendons}  # their pulleys
    return joints or set(range(1, model.njnt))


def loops(model: Any) -> list[tuple[tuple[int, int], bool, set[int]]]:
    """Return the closed linkages.

    Returns:
        For each, the two sites that coincide, whether they are welded, and the joints around the
        loop.
    """
    import mujoco

    found = []
    for index in np.flatnonzero(model.eq_objtype == mujoco.mjtObj.mjOBJ_SITE):
        one, other = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
        ends = [set(joints_to(model, int(model.site_bodyid[site]))) for site in (one, other)]
        weld = model.eq_type[index] == mujoco.mjtEq.mjEQ_WELD
        found.append(((one, other), bool(weld), ends[0] ^ ends[1]))
    return found


Tie = dict[int, float]  # joints that a taut tendon couples, with their coefficients


def ties(model: Any) -> dict[str, Tie]:
    """Return the couplings by taut tendons, by the names of these."""
    import mujoco

    found = {}
    for tendon in model.eq_obj1id[model.eq_type == mujoco.mjtEq.mjEQ_TENDON].tolist():
        wraps = model.tendon_adr[tendon] + np.arange(model.tendon_num[tendon])
        pairs = zip(model.wrap_objid[wraps].tolist(), model.wrap_prm[wraps].tolist(), strict=True)
        found[model.tendon(tendon).name] = dict(pairs)
    return found


def _ties(model: Any, order: Indices, dependent: Indices, taut: list[Tie]) -> tuple[Floats, Floats]:
    """Return the linear equations of taut tendons, as in `Linkage.ties`.

    Springs without load balance in the motions N that tendons leave free: N · K · (q − rest) = 0.
    """
    rows = np.array([[tie.get(int(joint), 0.0) for joint in order] for tie in taut])
    rows = rows.reshape(-1, len(order))
    rows /= np.abs(rows).max(axis=1, initial=1e-9, keepdims=True)
    tied = dependent[rows[:, dependent].any(axis=0)]
    _, sizes, motions = np.linalg.svd(rows[:, tied])
    free = motions[int((sizes > 1e-9).sum()) :]
    stiffness = model.jnt_stiffness[order[tied]]
    balance = np.zeros((len(free), len(order)))
    balance[:, tied] = free * stiffness / max(stiffness.max(initial=0.0), 1e-9)
    address = model.jnt_qposadr[order]
    wanted = [rows @ model.qpos0[address], balance @ model.qpos_spring[address]]
    return np.vstack([rows, balance]), np.concatenate(wanted)


def _constraints(
    model: Any, own: set[int], path: list[int]
) -> tuple[dict[tuple[int, int], bool], list[tuple[int, int, Floats]], list[Tie], set[int]]:
    """Return the constraints of a leg.

    Args:
        model: MuJoCo's model.
        own: the driven joints of the leg.
        path: the joints between trunk and foot.

    Returns:
        Pinned sites and whether they are welded; couplings; taut tendons; and the joints that these
        move.
    """
    import mujoco

    others = motors(model) - own
    of_leg, moving = own | set(path) - others, set()
    pins: dict[tuple[int, int], bool] = {}
    couplings: dict[tuple[int, int], Floats] = {}
    taut: list[Tie] = []
    closed, tied = loops(model), ties(model).values()
    while True:
        before = len(pins) + len(couplings) + len(taut)
        for tie in tied:
            if tie.keys() & of_leg and not tie.keys() & others and tie not in taut:
                taut.append(tie)
                moving |= tie.keys() - own
        for sites, weld, around in closed:
            if around & of_leg and sites not in pins:
                pins[sites] = weld
                moving |= around - others - own
        for index in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
            pair = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
            passive = set(pair) - own
            if pair not in couplings and passive & of_leg and not passive & others:
                couplings[pair] = model.eq_data[index, :5].copy()
                moving |= passive
        of_leg |= moving
        if len(pins) + len(couplings) + len(taut) == before:
            break
    return pins, [(*pair, factors) for pair, factors in couplings.items()], taut, moving


def _last(order: Indices, path: list[int]) -> int:
    """Return the index in `order` of the last joint of a path; −1 without any."""
    found = np.flatnonzero(np.isin(order, path))
    return int(found[-1]) if len(found) else -1
