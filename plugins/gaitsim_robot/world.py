"""The world of a robot: its text on level ground, with servos and sensors, ready to simulate."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitsim_robot.anatomy import Anatomy, Floats
from gaitsim_robot.servos import Servo, add_servos

FRAME_RATE = 50.0  # Hz, of commands and of what is recorded


@dataclass(frozen=True, eq=False)
class World:
    """A compiled world and where its quantities are in the arrays of MuJoCo.

    Attributes:
        model: MuJoCo's compiled model.
        anatomy: of the robot.
        steps: physics steps a frame.
        start: full physics state of the robot that stands at rest, (states,).
        qpos: index of each leg joint in qpos, (joints,).
        dof: index of each leg joint in qvel, (joints,).
        ctrl: index of each leg joint's servo, (joints,).
        rest: control of all servos in the standing pose, (servos,).
        stall_torque: of each leg joint's servo, (joints,) N m.
        top_speed: of each leg joint's servo without load, (joints,) rad/s.
        torque: index in the sensor data of each leg joint's torque, (joints,).
        load: index of the force on each foot, (feet, 3).
        slide: index of the velocity of each foot's strongest contact, in the contact's frame,
            (feet, 3).
        feet: index of the position of each foot, (feet, 3).
        belly: index of the number of contacts of the trunk with the ground.
    """

    model: Any
    anatomy: Anatomy
    steps: int
    start: Floats
    qpos: Any
    dof: Any
    ctrl: Any
    rest: Floats
    stall_torque: Floats
    top_speed: Floats
    torque: Any
    load: Any
    slide: Any
    feet: Any
    belly: int


def build(
    spec: Any,
    anatomy: Anatomy,
    servos: Mapping[str, Servo],
    *,
    dt: float,
    friction: float,
    gravity: float,
    settle: float = 1.0,
) -> World:
    """Return the world of a robot.

    Args:
        spec: MuJoCo's specification of the robot's text, changed in place.
        anatomy: of the robot.
        servos: of the driven joints, by their names.
        dt: time step, s.
        friction: of the ground and all that touches it.
        gravity: m/s².
        settle: how long the robot stands before its start, s.
    """
    import mujoco

    spec.option.timestep = dt
    spec.option.gravity = [0.0, 0.0, -gravity]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    add_servos(spec, servos, dt)
    trunk = spec.worldbody.first_body()
    for geom in spec.geoms:
        geom.friction[0] = friction
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        friction=[friction, 0.005, 0.0001],
    )
    for leg in anatomy.legs:
        foot = spec.body(leg.foot)
        foot.add_site(name=f"foot {leg.name}", pos=leg.point)
        _contact(spec, f"load {leg.name}", foot.name, ("FOUND", "FORCE"), _NETFORCE)
        _contact(spec, f"slide {leg.name}", foot.name, ("LINVEL",), _MAXFORCE)
        spec.add_sensor(
            name=f"foot {leg.name}",
            type=mujoco.mjtSensor.mjSENS_FRAMEPOS,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=f"foot {leg.name}",
        )
    _contact(spec, "belly", trunk.name, ("FOUND",), _NETFORCE)
    for joint in anatomy.joints:
        spec.add_sensor(
            name=f"torque {joint}",
            type=mujoco.mjtSensor.mjSENS_JOINTACTFRC,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=joint,
        )
    model = spec.compile()

    def sensor(kind: str, names: tuple[str, ...], width: int, skip: int = 0) -> Any:
        first = [model.sensor(f"{kind} {name}").adr[0] + skip for name in names]
        return np.array(first, np.intp)[:, None] + np.arange(width)

    legs = tuple(leg.name for leg in anatomy.legs)
    qpos = np.array([model.joint(name).qposadr[0] for name in anatomy.joints], np.intp)
    rest = np.array(
        [
            anatomy.stance[model.jnt_qposadr[model.actuator_trnid[servo, 0]]]
            for servo in range(model.nu)
        ]
    )
    return World(
        model,
        anatomy,
        round(1 / (FRAME_RATE * dt)),
        _settled(model, anatomy.stance, rest, settle),
        qpos,
        np.array([model.joint(name).dofadr[0] for name in anatomy.joints], np.intp),
        np.array([model.actuator(name).id for name in anatomy.joints], np.intp),
        rest,
        np.array([servos[name].stall_torque for name in anatomy.joints]),
        np.array([servos[name].no_load_speed for name in anatomy.joints]),
        sensor("torque", anatomy.joints, 1)[:, 0],
        sensor("load", legs, 3, skip=1),
        sensor("slide", legs, 3),
        sensor("foot", legs, 3),
        int(model.sensor("belly").adr[0]),
    )


_MAXFORCE, _NETFORCE = 2, 3


def _contact(spec: Any, name: str, body: str, fields: tuple[str, ...], reduce: int) -> None:
    """Add a sensor of the contacts of a body with the ground."""
    import mujoco

    data = sum(1 << int(getattr(mujoco.mjtConDataField, f"mjCONDATA_{field}")) for field in fields)
    sensor = spec.add_sensor(
        name=name,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname="ground",
        reftype=mujoco.mjtObj.mjOBJ_BODY,
        refname=body,
    )
    sensor.intprm[:3] = [data, reduce, 1]


def _settled(model: Any, stance: Floats, rest: Floats, seconds: float) -> Floats:
    """Return the full physics state of the robot at rest, after it has stood for a while."""
    import mujoco

    data = _commanded(model, stance, rest)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    data = _commanded(model, data.qpos, rest)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state


def _commanded(model: Any, qpos: Floats, rest: Floats) -> Any:
    """Return the robot at rest at time 0, its servos commanded to the standing pose for long."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.ctrl[:] = rest
    for servo in range(model.nu):
        samples = model.actuator_history[servo, 0]
        if samples:
            held = np.full((samples, 1), rest[servo])
            mujoco.mj_initCtrlHistory(model, data, servo, None, held)
    return data
