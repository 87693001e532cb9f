"""Chains of hinges and slides: forward and inverse kinematics of whole populations.

Sources: R. W. Brockett, Robotic manipulators and the product of exponentials formula (1984);
T. Sugihara, Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method, IEEE
Transactions on Robotics 27 (2011) 984-991, whose damping follows the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import cos, matmul, norm, sin, solve
from gaitsim_robot.anatomy import Floats

ITERATIONS = 20
PLANAR = 0.95  # smallest cosine of the angle of hinges to y, in a leg that moves in the x-z plane
FARTHEST_TURN = 0.5  # rad or m, largest change of a joint in one iteration


@dataclass(frozen=True, eq=False)
class Chain:
    """Hinges and slides in series from the trunk to a tip, in the frame of the standing trunk.

    The values of hinges, called angles, are in rad, and those of slides in m.

    The chains of several bodies have leading axes, (…), that broadcast with those of the angles.

    Attributes:
        anchors: a point on each axis in the pose `zero`, (…, joints, 3) m.
        axes: direction of each axis in the pose `zero`, (…, joints, 3).
        tip: position of the tip in the pose `zero`, (…, 3) m.
        zero: angles of the reference pose, (…, joints) rad.
        lower: smallest angles, (…, joints) rad.
        upper: largest angles, (…, joints) rad.
        slides: whether each joint slides along its axis, (joints,).
    """

    anchors: Floats
    axes: Floats
    tip: Floats
    zero: Floats
    lower: Floats
    upper: Floats
    slides: NDArray[np.bool_]

    @property
    def mirrored_axes(self) -> Floats:
        """The axes, (joints, 3), of a mirrored leg whose angles have the same signs."""
        mirrored: Floats = self.axes * np.where(self.slides[:, None], [1, -1, 1], [-1, 1, -1])
        return mirrored

    @property
    def length(self) -> Floats:
        """Length along the anchors to the tip, (…) m."""
        corners = np.concatenate([self.anchors, self.tip[..., None, :]], axis=-2)
        found = norm(np.diff(corners, axis=-2)).sum(axis=-1)
        return np.where(found > 0, found, 1.0)

    def place(self, angles: Floats) -> Floats:
        """Return the positions of the tip, (..., 3) m, for angles, (..., joints) rad."""
        return self._pose(np.ascontiguousarray(angles - self.zero))[0]

    def rotation(self, angles: Floats) -> Floats:
        """Return the tip's rotation from `zero`, (..., 3, 3), for angles, (..., joints) rad."""
        return self._pose(np.ascontiguousarray(angles - self.zero))[1]

    def weights(self, level: bool) -> Floats:
        """Return weights for `solve` that suit the number of joints, (…, 6).

        Three joints control the whole position; two control mainly its forward and upward
        components. With `level`, further joints prevent the foot from pitching, rolling and yawing,
        in this order.
        """
        joints = self.zero.shape[-1]
        along = np.abs(self.axes[..., 1])
        planar = np.where(self.slides, along**2 < 1 - PLANAR**2, along > PLANAR).all(axis=-1)
        aside = np.where(planar, 0.0, 1.0 if joints > 2 else 0.1)
        spare = np.where(planar, joints - 2, joints - 3) * level
        one = np.ones_like(aside)
        place = [one, aside, one] if joints > 1 else [0.1 * one, 0.1 * one, one]
        turns = [(spare > 1) & ~planar, spare > 0, (spare > 2) & ~planar]
        return np.stack([*place, *(0.3 * self.length * turn for turn in turns)], axis=-1)

    def solve(
        self, targets: Floats, start: Floats, hold: Floats, weights: Floats,
        iterations: int = ITERATIONS,
    ) -> Floats:  # fmt: skip
        """Return angles within the limits that move the tip to the targets, or close to them.

        Args:
            targets: target positions, (..., 3) m.
            start: initial angles, (..., joints) rad, or (joints,) for all targets.
            hold: angles at which the tip has the wanted orientation, (..., joints) rad.
            weights: weights of the errors in x, y, z, and of the rotations about x, y, z in metres
                per radian, (..., 6).
            iterations: number of iterations of the Levenberg-Marquardt method.

        Returns:
            The angles, (..., joints) rad. Each target is solved independently of the others.
        """
        joints = self.zero.shape[-1]
        angles = np.broadcast_to(start, (*targets.shape[:-1], joints)).copy()
        orientation = self._pose(hold - self.zero)[1]
        rows = np.flatnonzero(weights.reshape(-1, 6).any(axis=0))
        for _ in range(iterations):
            tips, rotation, anchors, axes = self._pose(angles - self.zero)
            error = np.concatenate([targets - tips, turn_to(rotation, orientation)], axis=-1)
            error = (error * weights)[..., rows]
            slope = jacobian(tips, anchors, axes, self.slides) * weights[..., None]
            slope = slope[..., rows, :]
            angles = improved(angles, error, slope, self.lower, self.upper, self.length)
        return angles

    def _pose(self, turned: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return tips (..., 3), rotations (..., 3, 3), anchors and axes (..., joints, 3)."""
        shape = turned.shape[:-1]
        sine, versine = sin(turned), 1 - cos(turned)
        rotation = np.broadcast_to(np.eye(3), (*shape, 3, 3))
        shift = np.zeros((*shape, 3))
        anchors, axes = np.empty((*turned.shape, 3)), np.empty((*turned.shape, 3))
        for joint in range(turned.shape[-1]):
            anchor, axis = self.anchors[..., joint, :], self.axes[..., joint, :]
            anchors[..., joint, :] = multiply(rotation, anchor) + shift
            axes[..., joint, :] = multiply(rotation, axis)
            if self.slides[joint]:
                shift = shift + axes[..., joint, :] * turned[..., [joint]]
                continue
            rotation = matmul(rotation, turned_about(axis, sine[..., joint], versine[..., joint]))
            shift = anchors[..., joint, :] - multiply(rotation, anchor)
        return multiply(rotation, self.tip) + shift, rotation, anchors, axes


def improved(
    angles: Floats, error: Floats, slope: Floats, lower: Floats, upper: Floats, size: Floats
) -> Floats:
    """Return angles after an iteration of the Levenberg-Marquardt method, within their limits.

    Args:
        angles: the angles, (..., joints) rad.
        error: the errors, (..., rows) m.
        slope: how fast angles reduce the errors, (..., rows, joints) m/rad.
        lower: smallest angles, (..., joints) rad.
        upper: largest angles, (..., joints) rad.
        size: length of the leg, (...) m.
    """
    downhill = multiply(slope.swapaxes(-1, -2), error)
    stuck = ((angles <= lower) & (downhill < 0)) | ((angles >= upper) & (downhill > 0))
    slope = np.where(stuck[..., None, :], 0.0, slope)
    downhill = np.where(stuck, 0.0, downhill)
    damping = 0.5 * (error * error).sum(axis=-1) + 1e-6 * size * size
    normal = matmul(slope.swapaxes(-1, -2), slope)
    normal += damping[..., None, None] * np.eye(angles.shape[-1])
    step = np.clip(solve(normal, downhill), -FARTHEST_TURN, FARTHEST_TURN)
    better: Floats = np.clip(angles + step, lower, upper)
    return better


def pose_data(model: Any, qpos: Floats) -> Any:
    """Return `mujoco.MjData` of a robot in a pose, with kinematics and centres of mass."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def leg_chain(model: Any, data: Any, joints: Any, tip: Floats) -> Chain:
    """Return the chain of joints, given by index from the hip to the foot, in the pose of `data`.

    Missing or wide limits of hinges are replaced by half a turn in each direction.
    """
    zero = data.qpos[model.jnt_qposadr[joints]].copy()
    limited = model.jnt_limited[joints].astype(bool)
    lower, upper = model.jnt_range[joints].T
    return Chain(
        data.xanchor[joints].copy(),
        data.xaxis[joints].copy(),
        tip,
        zero,
        np.maximum(np.where(limited, lower, -np.inf), zero - np.pi),
        np.minimum(np.where(limited, upper, np.inf), zero + np.pi),
        sliding(model)[joints],
    )


def stacked(chains: Sequence[Chain], axes: int = 0) -> Chain:
    """Return the chains of several bodies as one.

    Args:
        chains: chains with joints of the same kinds.
        axes: number of axes to insert behind that of the bodies, such as for samples of a cycle.
    """

    def joined(name: str) -> Floats:
        found = np.stack([getattr(chain, name) for chain in chains])
        return np.expand_dims(found, tuple(range(1, 1 + axes)))

    names = ("anchors", "axes", "tip", "zero", "lower", "upper")
    return Chain(**{name: joined(name) for name in names}, slides=chains[0].slides)


def sliding(model: Any) -> NDArray[np.bool_]:
    """Return whether each joint of MuJoCo's model slides, (joints,)."""
    import mujoco

    slides: NDArray[np.bool_] = model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE
    return slides


def multiply(matrices: Floats, vectors: Floats) -> Floats:
    """Return the products of matrices, (..., n, m), and vectors, (..., m)."""
    return matmul(matrices, vectors[..., None])[..., 0]


def turned_about(axis: Floats, sine: Floats, versine: Floats) -> Floats:
    """Return rotations about axes, (..., 3), from the sine and 1 − cosine of their angles, (...).

    Returns:
        The rotations, (..., 3, 3).
    """
    x, y, z = np.moveaxis(axis, -1, 0)
    none = np.zeros_like(x)
    skew = np.stack([none, -z, y, z, none, -x, -y, x, none], axis=-1)
    skew = skew.reshape(*x.shape, 3, 3)
    turn: Floats = np.eye(3) + sine[..., None, None] * skew
    turn += versine[..., None, None] * matmul(skew, skew)
    return turn


def jacobian(tips: Floats, anchors: Floats, axes: Floats, slides: NDArray[np.bool_]) -> Floats:
    """Return the derivatives of the tip, m/rad, then of its rotation, rad/rad, (..., 6, joints).

    For slides, they are in m/m and rad/m.
    """
    lever = tips[..., None, :] - anchors
    columns = np.concatenate([cross(axes, lever), axes], axis=-1)
    if slides.any():
        columns[..., slides, :3], columns[..., slides, 3:] = axes[..., slides, :], 0.0
    return columns.swapaxes(-1, -2)


def cross(a: Floats, b: Floats) -> Floats:
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        product[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return product


def turn_to(rotation: Floats, orientation: Floats) -> Floats:
    """Return the first-order rotation vector from `rotation` to `orientation`, (..., 3) rad."""
    turn: Floats = np.zeros(rotation.shape[:-1])
    for column in range(3):
        turn += cross(rotation[..., column], orientation[..., column])
    return turn / 2
