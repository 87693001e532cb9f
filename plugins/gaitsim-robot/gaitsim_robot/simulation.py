"""The simulation of a robot: its text compiled with ground, servos and sensors."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gaitsim.plugin import Terrain, conjugate, product
from gaitsim.plugin.toolkit import Damage, Servo, cos, draw_push, sin
from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.chain import pose_data
from gaitsim_robot.damaged import apply_damage
from gaitsim_robot.measures import ratio
from gaitsim_robot.servos import VOLTAGE, add_servos
from gaitsim_robot.terrain import GROUND, Lattice, add_ground

GRIP = 10.0
"""MuJoCo's `impratio`: how much harder friction is than the contact itself.

With 1, MuJoCo's default, standing feet creep, so a gait can live off feet that yield. Models of
walking robots in MuJoCo Menagerie (Zakka et al. 2022) have elliptic cones and 100. From 10 on,
distances hardly change, and simulations take longer."""


TIPPED = 0.5  # cosine of the trunk's tilt, 60°, beyond which the robot has fallen
SUNK = 0.8  # share of the standing height; a robot with a lower trunk does not stand
SETTLE = 1.0  # s, duration of standing before the start
STILL = 0.2  # standing heights per second; after a second, a falling trunk is faster
STRONG = 100.0  # factor on the torque of servos, to measure the torque that standing requires


def settle(
    model: Any, anatomy: Anatomy, rest: Floats, belly: int, height: float
) -> tuple[Floats, bool, Floats]:
    """Let a robot stand for a while; one that crawls may also lie.

    Args:
        model: MuJoCo's compiled model.
        anatomy: anatomy of the robot.
        rest: control of all servos, (servos,).
        belly: sensor index of the number of contacts between trunk and ground.
        height: height of the intact robot's trunk when standing, m.

    Returns:
        The state at rest, whether the robot stands, and the share of its stall torque that each
        servo needs, (servos,). `Simulation` has them as `start`, `stands` and `effort`.
    """
    import mujoco

    stance = anatomy.stance
    settled, stands = _simulate_standing(model, stance, rest, belly, height)
    stands = stands or anatomy.crawls
    needed = settled.actuator_force
    if not stands:
        strong = copy.copy(model)
        strong.actuator_forcerange *= STRONG
        strong.actuator_gainprm[:, VOLTAGE] *= STRONG
        needed = _simulate_standing(strong, stance, rest, belly, height)[0].actuator_force
    start = _at_rest(model, settled.qpos if stands else stance, rest)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, start, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state, stands, ratio(np.abs(needed), model.actuator_forcerange[:, 1])


def _simulate_standing(
    model: Any, stance: Floats, rest: Floats, belly: int, height: float
) -> tuple[Any, bool]:
    """Return the robot after standing for a while, and whether it still stands.

    A standing robot is upright and still, and not far below `height`, m.
    """
    import mujoco

    data = _at_rest(model, stance, rest)
    mujoco.mj_step(model, data, round(SETTLE / model.opt.timestep))
    standing = np.empty(9)
    mujoco.mju_quat2Mat(standing, stance[3:7])
    upright = data.xmat[1, 6:] @ standing[6:] > TIPPED and data.qpos[2] > SUNK * height
    still = np.linalg.norm(data.qvel[:3]) < STILL * height
    return data, bool(upright and still and data.sensordata[belly] == 0)


def _at_rest(model: Any, qpos: Floats, rest: Floats) -> Any:
    """Return the robot at rest at time 0, with `rest` as control of its servos."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.ctrl[:] = rest
    return data


FRAME_RATE = 50.0  # Hz, for both commands and recorded frames
NEAR = 0.01  # × length of the trunk; bodies this close in the standing pose never collide


SIZES = (
    "nq", "nv", "na", "nu", "nbody", "njnt", "ngeom", "nsite", "neq", "ntendon", "nwrap", "nmocap",
    "nM", "nB", "nC", "nD", "nJmom", "nsensordata",
)  # fmt: skip
"""MuJoCo's names of the sizes of `MjData`; its signature also counts excluded pairs of bodies."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A robot compiled with its ground, and the indices of its quantities in MuJoCo's arrays.

    Attributes:
        model: MuJoCo's compiled model.
        anatomy: anatomy of the robot, with its damage.
        damage: damage of the robot.
        servos: servos of the driven joints by the joints' names.
        steps: number of physics steps per frame.
        height: height of the trunk in the intact robot's standing pose, m.
        start: full physics state of the robot standing at rest, (states,).
        stands: whether the robot remains standing when its servos hold the standing pose; if not,
            it still starts in that pose.
        effort: share of its stall torque that the servo of each leg joint needs for standing,
            (joints,): more than 1 if the servo is too weak, 0 for a servo without force. If the
            robot falls, the share is measured with stronger servos.
        qpos: index of each leg joint in qpos, (joints,).
        dof: index of each leg joint in qvel, (joints,).
        ctrl: index of each leg joint's servo, (joints,).
        rest: control of all servos in the standing pose, (servos,).
        torque: index in the sensor data of each leg joint's torque, (joints,).
        load: index of the force on each foot, (feet, 3).
        slide: index of the velocity of each foot's strongest contact, in the contact's frame,
            (feet, 3).
        feet: index of the position of each foot, (feet, 3).
        belly: index of the number of contacts between trunk and ground.
        offset: constant error of each leg joint relative to its command, (joints,) rad, such as
            from an inexactly mounted servo horn.
        ground: uneven ground; None for level ground at z = 0.
        world: values of conditions by name.
        bodies: robots of the individuals of a population with their own dimensions, which share
            all indices, servos' latency and world; () if all have the dimensions of this robot.
    """

    model: Any
    anatomy: Anatomy
    damage: tuple[Damage, ...]
    servos: Mapping[str, Servo]
    steps: int
    height: float
    start: Floats
    stands: bool
    effort: Floats
    qpos: Any
    dof: Any
    ctrl: Any
    rest: Floats
    torque: Any
    load: Any
    slide: Any
    feet: Any
    belly: int
    offset: Floats
    ground: Terrain | None = None
    world: Mapping[str, float] = field(default_factory=dict)
    bodies: tuple["Simulation", ...] = ()

    def of_bodies(self, bodies: Sequence["Simulation"]) -> "Simulation":
        """Return the simulation of a population of robots with other dimensions than this one.

        Raises:
            RuntimeError: a model has other parts, with which MuJoCo's rollout would overwrite
                foreign memory.
        """
        own = [getattr(self.model, name) for name in SIZES]
        if any([getattr(body.model, name) for name in SIZES] != own for body in bodies):
            raise RuntimeError("a robot with other dimensions has other bodies, joints or sensors")
        return replace(self, bodies=tuple(bodies))

    def select(self, individuals: Any) -> "Simulation":
        """Return the simulation of some individuals of a population, (individuals,)."""
        if not self.bodies:
            return self
        chosen = np.arange(len(self.bodies))[individuals]
        return replace(self, bodies=tuple(self.bodies[index] for index in chosen))

    @property
    def each(self) -> tuple["Simulation", ...]:
        """The robots of the individuals, or this one for all."""
        return self.bodies or (self,)

    @property
    def models(self) -> Any:
        """The model of all individuals, or a list of theirs, as MuJoCo's rollout takes it."""
        return [body.model for body in self.bodies] if self.bodies else self.model

    @property
    def starts(self) -> Floats:
        """The states at the start, (individuals or 1, states)."""
        return np.array([body.start for body in self.each])

    @property
    def mass(self) -> Floats:
        """The masses, (individuals or 1,) kg."""
        return np.array([body.anatomy.mass for body in self.each])

    def above(self, points: Floats) -> Floats:
        """Return the height above the ground, (individuals, …) m, of points, (…, 3) m."""
        height: Floats = points[..., 2]
        if self.ground is None:
            return height
        if not self.bodies:
            return height - self.ground.height(points)
        pairs = zip(self.bodies, points, strict=True)
        return np.stack([body.above(places) for body, places in pairs])

    def push(self, frames: int) -> tuple[int, Floats]:
        """Return the frame of the push in a rollout, and the change of velocity, (3,) m/s."""
        frame, direction = draw_push(self.world, frames)
        speed = self.world.get("push", 0.0)
        return frame, speed * np.array([cos(direction), sin(direction), 0.0])

    @property
    def latency(self) -> float:
        """Delay from a command to the torque of the servos, s."""
        return max(servo.latency for servo in self.servos.values())

    @property
    def command_rate(self) -> float:
        """Rate of the commands, Hz."""
        return self.world.get("command_rate", FRAME_RATE)

    @property
    def stall_torque(self) -> Floats:
        """Stall torque of each leg joint's servo, (individuals or 1, joints) N m."""
        return np.array(
            [[one.servos[name].stall_torque for name in one.anatomy.joints] for one in self.each]
        )

    @property
    def continuous_torque(self) -> Floats:
        """Torque that servos can deliver for long, (individuals or 1, joints) N m; 0 if unknown."""
        shares = [[one.servos[name].continuous for name in one.anatomy.joints] for one in self.each]
        return np.array(shares) * self.stall_torque

    @property
    def top_speed(self) -> Floats:
        """Speed of each leg joint's servo without load, (joints,) rad/s."""
        return np.array([self.servos[name].no_load_speed for name in self.anatomy.joints])

    def turn(self, quaternions: Floats) -> Floats:
        """Return the rotations of the trunk relative to the standing pose, (…, 4).

        The trunk's quaternion when standing is not the identity for all files: see `Anatomy`.
        """
        return product(quaternions, conjugate(self.anatomy.stance[3:7]))


def build(
    spec: Any,
    anatomy: Anatomy,
    servos: Mapping[str, Servo],
    *,
    dt: float,
    friction: float,
    gravity: float,
    damage: Sequence[Damage] = (),
    lattice: Lattice | None = None,
) -> Simulation:
    """Return the simulation of a robot on its ground.

    Args:
        spec: MuJoCo's specification of the robot's text, changed in place.
        anatomy: anatomy of the intact robot.
        servos: servos of its driven joints by the joints' names.
        dt: time step, s.
        friction: friction of the ground and of all geoms.
        gravity: acceleration of gravity, m/s².
        damage: damage to legs and joints.
        lattice: lattice of uneven ground; None for a level plane.
    """
    import mujoco

    spec.option.timestep = dt
    spec.option.gravity = [0.0, 0.0, -gravity]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = GRIP
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE  # a third faster for six legs
    if not anatomy.crawls:
        _exclude_overlaps(spec, anatomy)
    height = float(anatomy.stance[2])
    if damage:
        anatomy, servos = apply_damage(spec, anatomy, servos, damage)
    pulling = {}
    for motor in spec.actuators:  # of the text
        if motor.trntype == mujoco.mjtTrn.mjTRN_TENDON:
            pulling[motor.target] = float(motor.gear[0])
        spec.delete(motor)
    add_servos(spec, servos, pulling)
    for name in anatomy.rolling:
        spec.joint(name).limited = mujoco.mjtLimited.mjLIMITED_FALSE
        spec.actuator(name).ctrllimited = mujoco.mjtLimited.mjLIMITED_FALSE
    trunk = spec.worldbody.first_body()
    for geom in spec.geoms:
        geom.friction[0] = friction
    add_ground(spec, anatomy, lattice, friction)
    for leg in anatomy.legs:
        foot = spec.body(leg.foot)
        foot.add_site(name=f"world: foot {leg.name}", pos=leg.point)
        _add_contact_sensor(spec, f"load {leg.name}", foot.name, ("FOUND", "FORCE"), _NETFORCE)
        _add_contact_sensor(spec, f"slide {leg.name}", foot.name, ("LINVEL",), _MAXFORCE)
        spec.add_sensor(
            name=f"foot {leg.name}",
            type=mujoco.mjtSensor.mjSENS_FRAMEPOS,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=f"world: foot {leg.name}",
        )
    _add_contact_sensor(spec, "belly", trunk.name, ("FOUND",), _NETFORCE)
    for joint in anatomy.joints:
        spec.add_sensor(
            name=f"torque {joint}",
            type=mujoco.mjtSensor.mjSENS_ACTUATORFRC,
            objtype=mujoco.mjtObj.mjOBJ_ACTUATOR,
            objname=joint,
        )
    model = spec.compile()

    def sensor(kind: str, names: tuple[str, ...], width: int, skip: int = 0) -> Any:
        first = [model.sensor(f"{kind} {name}").adr[0] + skip for name in names]
        return np.array(first, np.intp)[:, None] + np.arange(width)

    legs = tuple(leg.name for leg in anatomy.legs)
    qpos = np.array([model.joint(name).qposadr[0] for name in anatomy.joints], np.intp)
    servoed = [model.joint(model.actuator(index).name).id for index in range(model.nu)]
    rest = anatomy.stance[model.jnt_qposadr[servoed]]
    ctrl = np.array([model.actuator(name).id for name in anatomy.joints], np.intp)
    belly = int(model.sensor("belly").adr[0])
    start, stands, effort = settle(model, anatomy, rest, belly, height)
    return Simulation(
        model,
        anatomy,
        tuple(damage),
        servos,
        round(1 / (FRAME_RATE * dt)),
        height,
        start,
        stands,
        effort[ctrl],
        qpos,
        np.array([model.joint(name).dofadr[0] for name in anatomy.joints], np.intp),
        ctrl,
        rest,
        sensor("torque", anatomy.joints, 1)[:, 0],
        sensor("load", legs, 3, skip=1),
        sensor("slide", legs, 3),
        sensor("foot", legs, 3),
        belly,
        offset=np.zeros(len(ctrl)),
    )


_MAXFORCE, _NETFORCE = 2, 3


def _add_contact_sensor(
    spec: Any, name: str, body: str, fields: tuple[str, ...], reduce: int
) -> None:
    """Add a sensor for the contacts between a body and the ground."""
    import mujoco

    data = sum(1 << int(getattr(mujoco.mjtConDataField, f"mjCONDATA_{field}")) for field in fields)
    sensor = spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname=GROUND,
        reftype=mujoco.mjtObj.mjOBJ_BODY,
        refname=body,
    )
    sensor.intprm[:3] = [data, reduce, 1]


def _exclude_overlaps(spec: Any, anatomy: Anatomy) -> None:
    """Exclude collisions of bodies that overlap or almost touch in the standing pose.

    Real parts cannot overlap, but their hulls can, such as the hulls of a thigh and the trunk.
    """
    bodies = [body.name for body in spec.bodies]
    for first, second in sorted(near_links(spec, anatomy.stance, NEAR * anatomy.length)):
        spec.add_exclude(bodyname1=bodies[first], bodyname2=bodies[second])


def near_links(spec: Any, pose: Floats, margin: float) -> set[tuple[int, int]]:
    """Return the pairs of links of a specification that are within a margin, m, in a pose."""
    near = spec.copy()
    for geom in near.geoms:
        geom.margin = margin
    model = near.compile()
    return touching_links(model, pose_data(model, pose))


def touching_links(model: Any, data: Any) -> set[tuple[int, int]]:
    """Return the pairs of links that touch in the pose of `data`, with its centres of mass."""
    import mujoco

    mujoco.mj_collision(model, data)
    pairs = [model.geom_bodyid[[one.geom1, one.geom2]].tolist() for one in data.contact]
    return {(min(pair), max(pair)) for pair in pairs}
