"""Read an MJCF document into a tree of bodies, with MuJoCo's own parser and compiler."""

import math
from typing import Any
from xml.etree.ElementTree import Element, tostring

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from gaitsim_robot.errors import RobotError, format_names
from gaitsim_robot.importing.files import RobotFiles
from gaitsim_robot.importing.includes import check_size, inline_includes, modernise, resolve_files
from gaitsim_robot.importing.solids import robot_size
from gaitsim_robot.importing.tree import (
    Body,
    Closure,
    Coupling,
    Floats,
    Place,
    RobotTree,
    Shape,
    Tendon,
    TreeJoint,
    report,
)
from gaitsim_robot.markup import LARGEST, LARGEST_INERTIA
from gaitsim_robot.shapes import mesh_vertices
from gaitsim_robot.text import disable_log

_TINY = 1e-9  # kg and kg·m²; lets MuJoCo compile massless bodies, which repairs detect later
_JOINTS = ("free", "ball", "slide", "hinge")  # the order of mjtJoint
_GEOMS = {2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
_CHECKED = {
    "geom": ("pos", "quat", "size"),
    "body": ("pos", "quat", "mass", "ipos", "iquat", "inertia"),
    "mesh": ("vert",),
    "jnt": ("pos", "axis", "range", "stiffness"),
    "dof": ("damping", "armature", "frictionloss"),
    "qpos": ("0", "spring"),
    "key": ("qpos",),
    "site": ("pos", "quat"),
    "eq": ("data",),
    "actuator": ("gear", "gainprm", "biasprm"),
}
# A huge range means no limit.
_UNLIMITED = ("jnt_range", "eq_data", "actuator_gear", "actuator_gainprm", "actuator_biasprm")
_LARGEST = {"body_inertia": LARGEST_INERTIA, **dict.fromkeys(_UNLIMITED, np.inf)}
_ENDLESS = (-np.inf, np.inf)
_Pairs = dict[str, float]
_STANDING_NAMES = ("stand", "home")


def read_mjcf(root: Element, files: RobotFiles, where: str, scale: float = 1.0) -> RobotTree:
    """Return the robot of an MJCF document: the tree of bodies with the most joints.

    Args:
        root: the document.
        files: files that the robot may use.
        where: path of the file, for messages.
        scale: later factor of all lengths; masses that MuJoCo computes from
            densities are already those of the resulting volumes.
    """
    repairs: list[str] = []
    inline_includes(root, files, where)
    modernise(root, repairs)
    assets, incomplete = resolve_files(root, files, where, repairs)
    check_size(root, assets, where)
    model = _compiled(tostring(root, "unicode"), assets, where, scale)
    _check_values(model, where)
    robot = _MjcfReader(model, where, repairs).robot()
    for body in robot.root.walk():
        body.incomplete = body.name in incomplete
    return robot


def _compiled(text: str, assets: dict[str, bytes], where: str, scale: float) -> Any:
    disable_log()
    try:
        spec = mujoco.MjSpec.from_string(text, assets=assets)
        spec.compiler.balanceinertia = True
        for geom in spec.geoms:
            geom.density *= scale**3
        try:
            return spec.compile()
        except ValueError as error:
            if "mass" not in str(error):
                raise
            spec.compiler.boundmass = spec.compiler.boundinertia = _TINY
            return spec.compile()
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        raise RobotError(
            f"MuJoCo cannot compile the model: {' '.join(str(error).split())[:300]}",
            where=where,
            remedy="fix this error; the file may need a different version of MuJoCo",
        ) from None


def _check_values(model: Any, where: str) -> None:
    """Check the numbers of a compiled model; MuJoCo accepts NaN, infinity and huge numbers."""
    for kind, attributes in _CHECKED.items():
        for attribute in attributes:
            array = f"{kind}_{attribute}".replace("qpos_0", "qpos0")
            values = getattr(model, array)
            rows = values.reshape(len(values), math.prod(values.shape[1:]))
            most = _LARGEST.get(array, LARGEST)
            valid = np.isfinite(rows) & (np.abs(rows) <= most)
            if attribute.endswith("quat"):  # MuJoCo turns a huge quaternion into zeros
                valid &= (np.abs(np.linalg.norm(rows, axis=1) - 1) < 0.01)[:, None]
            if not valid.all():
                index = int(np.argmin(valid.all(axis=1)))
                raise RobotError(
                    f"invalid {attribute} of {_element(model, kind, index)}",
                    where=where,
                    allowed=f"finite numbers within ±{most:,.0f}, and rotations other than 0",
                    remedy="correct nan, inf, zero and huge numbers of this element in the file",
                )


def _element(model: Any, kind: str, index: int) -> str:
    """Return the kind and the name of the element to which a row of an array belongs."""
    if kind == "qpos":
        return "a joint"
    if kind == "dof":
        kind, index = "jnt", int(model.dof_jntid[index])
    if kind == "mesh":
        index = int(np.searchsorted(model.mesh_vertadr, index, side="right")) - 1
    kind = {"jnt": "joint", "eq": "equality"}.get(kind, kind)
    return f"the {kind} {_name(model, kind, index) or index!r}"


def _name(model: Any, kind: str, index: int) -> str:
    return mujoco.mj_id2name(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), index) or ""


class _MjcfReader:
    def __init__(self, model: Any, where: str, repairs: list[str]) -> None:
        self._model = model
        self._where = where
        self._repairs = repairs
        self._bodies: dict[int, Body] = {}
        self._actuators, dropped = _actuators(model)
        names = [self._name("actuator", index) for index in dropped]
        report(repairs, "dropped actuators other than motors and position servos of joints", names)
        at_joint = np.isin(model.actuator_trntype, _ON_JOINTS)
        at_tendon = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON
        self._driven = set(model.actuator_trnid[at_joint, 0].tolist())
        self._pulled = set(model.actuator_trnid[at_tendon, 0].tolist())
        self._stated = bool(self._driven or self._pulled)
        self._missing: list[str] = []

    def robot(self) -> RobotTree:
        model = self._model
        if model.nbody < 2:
            raise RobotError(
                "the model has no bodies", where=self._where, allowed="a trunk with legs"
            )
        joints = np.bincount(model.body_rootid, model.body_jntnum, model.nbody)
        joints[0] = -1
        root = int(joints.argmax())
        inside = [body for body in range(1, model.nbody) if model.body_rootid[body] == root]
        for body in inside:
            self._bodies[body] = self._body(body)
            if body != root:
                self._bodies[int(model.body_parentid[body])].children.append(self._bodies[body])
        others = [self._name("body", one) for one in set(model.body_rootid) - {0, root}]
        report(self._repairs, "dropped bodies outside the robot", others)
        name = bytes(model.names).split(b"\0", 1)[0].decode(errors="replace")
        root_body = self._bodies[root]
        robot = RobotTree(name, root_body, repairs=self._repairs, motors_stated=self._stated)
        if not robot.root.joints:
            self._repairs.append(f"freed {robot.root.name!r}, which was fixed to the world")
        self._equalities(robot)
        if not self._stated:
            followers = {coupling.follower for coupling in robot.couplings}
            followers |= {taut.joints[0][0] for taut in robot.tendons}
            for joint in robot.joints:
                joint.driven = joint.name not in followers
        self._excludes(robot)
        robot.stand = self._stand(root, inside)
        self._tendons(robot)
        self._check_motors(robot)
        return robot

    def _tendons(self, robot: RobotTree) -> None:
        """Keep the springs, limits and motors of fixed tendons; warn about other tendons."""
        model = self._model
        for index in range(model.ntendon):
            name, pairs = self._name("tendon", index), self._pairs(index)
            given = {
                key: [float(value)]
                for key in ("stiffness", "damping", "frictionloss")
                if (value := getattr(model, f"tendon_{key}")[index])
            }
            if "stiffness" in given:
                given["springlength"] = model.tendon_lengthspring[index].tolist()
            if model.tendon_limited[index]:
                given["range"] = model.tendon_range[index].tolist()
            if pairs and index in self._pulled:
                self._pull(robot, index, pairs, given)
            elif pairs and given:
                robot.tendons.append(Tendon(name, tuple(pairs.items()), given))
            elif given or index in self._pulled:
                self._missing.append(name)
        if self._missing:
            robot.warnings.append(
                "tendons in space, and couplings by polynomials of tendons, are not simulated: "
                f"{format_names(self._missing)}"
            )

    def _pairs(self, tendon: int) -> _Pairs:
        """Return the joints of a fixed tendon and their coefficients; {} for other tendons."""
        model = self._model
        first = int(model.tendon_adr[tendon])
        wraps = slice(first, first + int(model.tendon_num[tendon]))
        joints = model.wrap_objid[wraps].tolist()
        fixed = (model.wrap_type[wraps] == mujoco.mjtWrap.mjWRAP_JOINT).all()
        moved = self._bodies.keys() - {next(iter(self._bodies))}  # the trunk has no joints
        if not fixed or not {int(model.jnt_bodyid[joint]) for joint in joints} <= moved:
            return {}
        names = [self._name("joint", joint) for joint in joints]
        return dict(zip(names, model.wrap_prm[wraps].tolist(), strict=True))

    def _pull(self, robot: RobotTree, tendon: int, pairs: _Pairs, given: dict[str, Any]) -> None:
        """Add a tendon that a motor pulls, and its pulley, which turns with it.

        The motor acts on the tendon; the pulley, with hardly any inertia, only shows its length as
        an angle. It is on the axis of the first joint without a motor of its own.
        """
        model = self._model
        joints = {joint.name: joint for joint in robot.joints}
        first = next((name for name in pairs if not joints[name].driven), next(iter(pairs)))
        owner = next(body for body in robot.root.walk() if joints[first] in body.joints)
        parent = next(body for body in robot.root.walk() if owner in body.children)
        name = self._name("tendon", tendon)
        while name in joints:
            name += " pulley"
        radius = max(map(abs, pairs.values()))  # turns about as far as the joints
        own = model.tendon_range[tendon] if model.tendon_limited[tendon] else _ENDLESS
        limits = [
            sorted(f * end for end in joints[one].range or _ENDLESS) for one, f in pairs.items()
        ]
        low, high = np.clip(np.sum(limits, axis=0), *own) / radius
        torque, stiffness, damping = self._actuators[model.njnt + tendon].tolist()
        pulley = TreeJoint(
            name,
            joints[first].kind,
            joints[first].axis.copy(),
            range=(low, high) if np.isfinite([low, high]).all() else None,
            torque=torque * radius,
            armature=1e-7 * robot.mass * robot_size(robot) ** 2,
            reference=float(model.tendon_length0[tendon]) / radius,
            servo_stiffness=stiffness * radius**2,
            servo_damping=damping * radius**2,
        )
        place = owner.place @ Place(joints[first].position.copy())
        mass, inertia = 1e-6 * robot.mass, 0.1 * pulley.armature * np.eye(3)
        body = Body(f"{name} pulley", place, mass, inertia=inertia, joints=[pulley], pulley=True)
        parent.children.append(body)
        ends = tuple(pairs.items())
        robot.tendons += [
            Tendon(name, ends, given, pulley=name, radius=radius),
            Tendon(f"{name} pulley", (*ends, (name, -radius)), {}, taut=True),
        ]
        if robot.stand is not None:
            angles = robot.stand[1]
            angles[name] = sum(factor * angles[one] for one, factor in ends) / radius

    def _check_motors(self, robot: RobotTree) -> None:
        """Refuse tendons whose motors pull against other motors or couplings."""
        taut = [one for one in robot.tendons if one.taut]
        ties = [dict(one.joints) for one in taut]
        ties += [{one.follower: 1.0, one.leader: -one.coefficients[1]} for one in robot.couplings]
        free = [joint.name for joint in robot.joints if not joint.driven]
        rows = np.array([[tie.get(name, 0.0) for name in free] for tie in ties])
        if taut and np.linalg.matrix_rank(rows) < len(rows):
            raise RobotError(
                f"motors or couplings of tendons pull against each other, or against motors of "
                f"their joints: {format_names([one.name for one in taut])}",
                where=self._where,
                remedy="remove the motor of an antagonist from the file",
            )

    def _name(self, kind: str, index: int) -> str:
        return _name(self._model, kind, index) or f"{kind} {index}"

    def _body(self, index: int) -> Body:
        model = self._model
        turned = _rotation(model.body_iquat[index])
        mass = float(model.body_mass[index])
        body = Body(
            self._name("body", index),
            Place(model.body_pos[index].copy(), _rotation(model.body_quat[index])),
            0.0 if mass <= 1.001 * _TINY else mass,
            model.body_ipos[index].copy(),
            turned @ np.diag(model.body_inertia[index]) @ turned.T,
        )
        first = model.body_jntadr[index]
        body.joints = [self._joint(first + joint) for joint in range(model.body_jntnum[index])]
        first = model.body_geomadr[index]
        for geom in range(first, first + model.body_geomnum[index]):
            if (kind := _GEOMS.get(int(model.geom_type[geom]))) is not None:
                body.shapes.append(self._shape(geom, kind))
        return body

    def _shape(self, geom: int, kind: str) -> Shape:
        model = self._model
        place = Place(model.geom_pos[geom].copy(), _rotation(model.geom_quat[geom]))
        contype, conaffinity = int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])
        return Shape(
            kind,
            place,
            model.geom_size[geom][: _SIZES.get(kind, 0)].copy(),
            mesh_vertices(model, geom) if kind == "mesh" else None,
            bool(contype or conaffinity),
            contype,
            conaffinity,
        )

    def _joint(self, index: int) -> TreeJoint:
        model = self._model
        dof, angle = model.jnt_dofadr[index], model.jnt_qposadr[index]
        limits = tuple(map(float, model.jnt_range[index])) if model.jnt_limited[index] else None
        if index in self._driven and _JOINTS[model.jnt_type[index]] == "ball":
            raise RobotError(
                f"a motor drives the ball joint {self._name('joint', index)!r}",
                where=self._where,
                allowed="motors of hinges; balls without motors are passive",
                remedy="replace it by three hinges with a motor each",
            )
        torque, stiffness, damping = self._actuators[index].tolist()
        if model.jnt_actfrclimited[index]:
            own = float(np.abs(model.jnt_actfrcrange[index]).max())
            torque = min(torque, own) if torque else own
        return TreeJoint(
            self._name("joint", index),
            _JOINTS[model.jnt_type[index]],
            model.jnt_axis[index].copy(),
            model.jnt_pos[index].copy(),
            None if limits is None else (limits[0], limits[1]),
            torque,
            0.0,
            float(model.dof_damping[dof]),
            float(model.dof_armature[dof]),
            float(model.dof_frictionloss[dof]),
            float(model.jnt_stiffness[index]),
            float(model.qpos0[angle]),
            float(model.qpos_spring[angle]),
            stiffness,
            damping,
            not self._stated or index in self._driven,
        )

    def _equalities(self, robot: RobotTree) -> None:
        model = self._model
        kinds = mujoco.mjtEq
        lost: set[str] = set()
        for index in range(model.neq):
            kind = int(model.eq_type[index])
            first, second = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
            data = model.eq_data[index]
            if kind == kinds.mjEQ_JOINT and second >= 0:
                names = (self._name("joint", first), self._name("joint", second))
                # MuJoCo's polynomial uses angles relative to the initial ones.
                robot.couplings.append(Coupling(*names, tuple(map(float, data[:5]))))
            elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD) and self._close(
                robot, index, kind == kinds.mjEQ_WELD
            ):
                continue
            elif kind == kinds.mjEQ_TENDON:
                self._couple(robot, first, second, data)
            else:
                lost.add(str(kinds(kind).name).removeprefix("mjEQ_").lower())
        if lost:
            self._repairs.append(f"dropped equality constraints: {', '.join(sorted(lost))}")

    def _couple(self, robot: RobotTree, first: int, second: int, data: Floats) -> None:
        """Keep a linear coupling of tendons as one taut tendon."""
        pairs, others = self._pairs(first), self._pairs(second) if second >= 0 else {}
        name = self._name("tendon", first)
        if not pairs or (second >= 0 and not others) or data[0] or data[2:5].any():
            self._missing.append(name)
            return
        for joint, factor in others.items():
            pairs[joint] = pairs.get(joint, 0.0) - data[1] * factor
        robot.tendons.append(Tendon(name, tuple(pairs.items()), {}, taut=True))

    def _close(self, robot: RobotTree, index: int, weld: bool) -> bool:
        model = self._model
        ids = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
        data = model.eq_data[index]
        if model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE:
            bodies = [int(model.site_bodyid[one]) for one in ids]
            places = [
                Place(model.site_pos[one].copy(), _rotation(model.site_quat[one])) for one in ids
            ]
        else:
            bodies = list(ids)
            places = [Place(data[:3].copy()), Place(data[3:6].copy())]
            if weld:
                places = [Place(data[3:6].copy(), _rotation(data[6:10])), Place(data[:3].copy())]
        if not all(body in self._bodies for body in bodies):
            return False
        names = f"closure {index} a", f"closure {index} b"
        for name, body, place in zip(names, bodies, places, strict=True):
            self._bodies[body].sites[name] = place
        robot.closures.append(Closure("weld" if weld else "connect", *names))
        return True

    def _excludes(self, robot: RobotTree) -> None:
        for signature in self._model.exclude_signature:
            pair = int(signature) >> 16, int(signature) & 0xFFFF
            if all(body in self._bodies for body in pair):
                first, second = (self._bodies[body].name for body in pair)
                robot.excludes.append((first, second))

    def _stand(self, root: int, inside: list[int]) -> tuple[Place, dict[str, float]] | None:
        """Return the pose of the keyframe whose name contains `stand` or `home`."""
        model = self._model
        names = [self._name("key", key).lower() for key in range(model.nkey)]
        found = [key for word in _STANDING_NAMES for key, name in enumerate(names) if word in name]
        if not found:
            return None
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, found[0])
        mujoco.mj_kinematics(model, data)
        angles: dict[str, float] = {}
        for joint in range(model.njnt):
            kind, name = _JOINTS[model.jnt_type[joint]], self._name("joint", joint)
            at = model.jnt_qposadr[joint]
            if model.jnt_bodyid[joint] not in inside:
                continue
            if kind in ("hinge", "slide"):
                angles[name] = float(data.qpos[at])
            elif kind == "ball":  # for the three hinges that replace it
                turn = Rotation.from_quat(data.qpos[at : at + 4], scalar_first=True)
                letters = zip("xyz", turn.as_euler("XYZ").tolist(), strict=True)
                angles |= {f"{name} {letter}": angle for letter, angle in letters}
        return Place(data.xpos[root].copy(), data.xmat[root].reshape(3, 3).copy()), angles


def _actuators(model: Any) -> tuple[Floats, list[int]]:
    """Return what actuators of joints and tendons do, and those that gaitsim cannot represent.

    The force of a position actuator is `kp · (control − angle) − kv · speed`. A joint may have a
    velocity actuator in addition, whose gain is then a part of `kv`.

    Returns:
        The largest torque, N·m, stiffness, N·m/rad, and damping, N·m·s/rad, of each joint's
        actuators, then of each tendon's, 0 if there is none, (joints + tendons, 3); and the
        indices of dropped actuators.
    """
    found = np.zeros((model.njnt + model.ntendon, 3))
    velocity: list[tuple[int, int]] = []
    dropped: list[int] = []
    for actuator in range(model.nu):
        bias = int(model.actuator_biastype[actuator])
        joint = int(model.actuator_trnid[actuator, 0])
        at_tendon = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_TENDON
        joint += model.njnt if at_tendon else 0
        if (
            not (at_tendon or model.actuator_trntype[actuator] in _ON_JOINTS)
            or model.actuator_gaintype[actuator] != mujoco.mjtGain.mjGAIN_FIXED
            or bias not in (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
        ):
            dropped.append(actuator)
            continue
        gear = abs(float(model.actuator_gear[actuator, 0]))
        stiffness, damping = (-gear * gear * model.actuator_biasprm[actuator, 1:3]).tolist()
        force = 0.0
        if model.actuator_forcelimited[actuator]:
            force = float(np.abs(model.actuator_forcerange[actuator]).max())
        elif model.actuator_ctrllimited[actuator] and bias == mujoco.mjtBias.mjBIAS_NONE:
            command = float(np.abs(model.actuator_ctrlrange[actuator]).max())
            force = command * abs(float(model.actuator_gainprm[actuator, 0]))
        found[joint, :2] = np.maximum(found[joint, :2], (force * gear, stiffness))
        found[joint, 2] += max(damping, 0.0)
        if bias == mujoco.mjtBias.mjBIAS_AFFINE and not stiffness > 0:
            velocity.append((actuator, joint))
    for actuator, joint in velocity:
        if not found[joint, 1]:
            found[joint, 2] = 0.0
            dropped.append(actuator)
    return found, sorted(dropped)


_ON_JOINTS = (0, 1)  # mjTRN_JOINT and mjTRN_JOINTINPARENT


def _rotation(quaternion: Floats) -> Floats:
    """Return the matrix of a quaternion (w, x, y, z), (3, 3)."""
    matrix: Floats = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
    return matrix
