"""Servos: position control within a motor's torque and speed, with latency.

A servo drives its joint with the torque `stiffness · (command − angle) − damping · speed` of a DC
motor, whose largest torque decreases linearly from the stall torque at rest to 0 at the no-load
speed. It is implemented as MuJoCo's `dcmotor`; `commands.delayed_commands` delays its commands.
For joints that slide, torques are forces in N, and angles are lengths in m.

A hobby servo has the damping of its motor, stall torque / no-load speed, as its electronics apply a
voltage proportional to the error, and back-EMF damps the motion. Gear friction, backlash and
heating are not modelled.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.toolkit import SERVOS, Servo
from gaitsim_robot.anatomy import Anatomy
from gaitsim_robot.chain import sliding
from gaitsim_robot.linkage import standing_chains

BAND = 0.25  # rad, largest error at which an unknown servo applies its full torque
NARROW = 0.02  # rad, the same for a stiffness in a file; higher ones are placeholders, and chatter
HOLD = 4.0  # × weight × reach per rad, smallest stiffness of an unknown servo; balances a biped
DAMPING_TIME = 0.03  # s, smallest damping / stiffness of an unknown servo: seven time steps
STABLE = 0.005  # s, the same for a stiffness in a file: half the largest time step
SPIN_UP = 0.01  # s, time in which stall torque spins an unloaded unknown servo up to no-load speed
SHARE = 0.5  # × weight × reach of a leg, torque limit if the file has none
LIFT = 2.0  # × weight × reach of a leg; higher torque limits in files are placeholders
PUSH = 20.0  # × weight, the same for forces of slides, which may push on a tenth of a leg's lever
SPEED = 10.0  # rad/s, speed limit if the file has none
FASTEST = 50.0  # rad/s; higher speed limits in files are placeholders
FROM_FILE = "the robot's file"

CONSTANT, GAIN, BRAKE, VOLTAGE = 1, 4, 6, 7
"""Indices in the gains of MuJoCo's dcmotor: motor constant, stiffness, damping, largest voltage."""


Limits = tuple[float | None, float | None, float | None]
"""Torque limit, speed limit and stiffness instead of those in the robot's text."""

ServoName = Literal["model", "ideal", "ax-12a", "sts3215", "mg995", "xl430-w250"]
"""Values of the option `organism.servo`.

- `model`: the limits, stiffness and damping in the robot's text. Missing limits are replaced by a
  torque of `SHARE` of the robot's weight times the reach of its longest leg, and by `SPEED`. Limits
  beyond `LIFT` and `FASTEST` are placeholders, and are reduced to these values. A slide has the
  limits of a hinge with that reach as its lever, but `PUSH` for `LIFT`.
- `ideal`: stiff, strong and without delay, to show what a gait could achieve.
"""


def joint_servos(
    model: Any,
    anatomy: Anatomy,
    name: ServoName = "model",
    torque_limit: float | None = None,
    speed_limit: float | None = None,
    latency: float | None = None,
    stiffness: float | None = None,
) -> dict[str, Servo]:
    """Return the servo of each driven joint.

    Args:
        model: `mujoco.MjModel` of the robot's text.
        anatomy: anatomy of the robot.
        name: name of the servo.
        torque_limit: stall torque instead of the servo's, N m; not for slides.
        speed_limit: no-load speed instead of the servo's, rad/s; not for slides.
        latency: latency instead of the servo's, s.
        stiffness: stiffness instead of the servo's, N m/rad; not for slides.

    Raises:
        GaitsimError: the servo turns, but a joint slides.
    """
    chains = standing_chains(model, anatomy)
    weight = 9.81 * anatomy.mass
    reach = max(math.dist(chain.anchors[0], chain.tip) for chain in chains)
    servos = {}
    for joint in (*anatomy.joints, *anatomy.held):
        slides = bool(sliding(model)[model.joint(joint).id])
        limits: Limits = (torque_limit, speed_limit, stiffness)
        limits = (None, None, None) if slides else limits
        load, lever = (weight, reach) if slides else (weight * reach, 1.0)
        if name == "model":
            servo = _servo_from_text(model, joint, load, lever, limits)
        elif name == "ideal":
            ends = LIFT * load, FASTEST * lever
            servo = _assumed_servo(name, *ends, load, lever, "no real servo")
        elif slides:
            raise GaitsimError(
                f"the servo {name!r} turns joints, and the joint {joint!r} slides",
                key="servo",
                allowed="'model' or 'ideal' for robots whose motors drive slides",
            )
        else:
            servo = SERVOS[name]
        torque, speed_given, stiff = limits
        if stiff is not None:
            damping = servo.damping / servo.stiffness * stiff
            servo = replace(servo, stiffness=stiff, damping=damping)
        servos[joint] = replace(
            servo,
            stall_torque=servo.stall_torque if torque is None else torque,
            no_load_speed=servo.no_load_speed if speed_given is None else speed_given,
            latency=servo.latency if latency is None else latency,
        )
    return servos


def add_servos(
    spec: Any, servos: Mapping[str, Servo], pulling: Mapping[str, float] = MappingProxyType({})
) -> None:
    """Add an actuator for each servo, named after its joint.

    The control of an actuator is the commanded angle, which is clipped to the range of the joint.
    An actuator replaces the joint's own torque limit. The joint's armature is raised to the servo's
    armature if it is smaller.

    Args:
        spec: MuJoCo's specification of the robot's text, changed in place.
        servos: servos by the names of their joints.
        pulling: angle per length of the tendons that servos pull, by the names of their pulleys.
    """
    import mujoco

    for name, servo in servos.items():
        joint = spec.joint(name)
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        kind = mujoco.mjtTrn.mjTRN_TENDON if name in pulling else mujoco.mjtTrn.mjTRN_JOINT
        actuator = spec.add_actuator(name=name, target=name, trntype=kind, ctrlrange=joint.range)
        if name in pulling:
            actuator.gear[0] = pulling[name]
        else:
            joint.armature = max(joint.armature, servo.armature)
        actuator.ctrllimited = mujoco.mjtLimited.mjLIMITED_TRUE
        if not servo.stall_torque:
            actuator.set_to_motor()
            actuator.gainprm[0] = 0.0
            continue
        # The nominal voltage of 1 is arbitrary, as it cancels out.
        actuator.set_to_dcmotor(
            motorconst=[0.0, 0.0],
            resistance=0.0,
            nominal=[1.0, servo.stall_torque, servo.no_load_speed],
            saturation=[servo.stall_torque, 0.0, 0.0],
            controller=[servo.stiffness, 0.0, servo.damping, 0.0, 0.0, 1.0],
            ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_POS),
        )


def set_servos(model: Any, servos: Mapping[str, Servo]) -> None:
    """Change the servos of a compiled robot, except for latency, as recompiling it would.

    Args:
        model: `mujoco.MjModel`, changed in place.
        servos: servos by the names of their joints; servos without force are skipped.
    """
    for name, servo in servos.items():
        if servo.stall_torque:
            actuator, constant = model.actuator(name).id, 1.0 / servo.no_load_speed
            model.actuator_gainprm[actuator, :2] = constant / servo.stall_torque, constant
            model.actuator_gainprm[actuator, [GAIN, BRAKE]] = servo.stiffness, servo.damping
            model.actuator_forcerange[actuator] = -servo.stall_torque, servo.stall_torque


def _servo_from_text(model: Any, joint: str, load: float, lever: float, limits: Limits) -> Servo:
    """Return the servo of a joint with the limits and the stiffness in the robot's text.

    `load` is the robot's weight × reach, N m, and `lever` is 1; for a slide, they are its weight,
    N, and its reach, m.
    """
    torque_limit, speed_limit, stiffness = limits
    index = model.joint(joint).id
    torque = float(model.jnt_actfrcrange[index, 1]) if model.jnt_actfrclimited[index] else 0.0
    speed = float(model.jnt_user[index, 0]) if model.nuser_jnt else 0.0
    kind, of_force, of_speed, of_stiffness = units_of(model, joint)
    most = (LIFT if kind == "torque" else PUSH) * load
    notes = []
    if torque_limit is None:
        assumed = f": {SHARE:g} × weight" + " × reach of the longest leg" * (kind == "torque")
        notes.append(_assumption(kind, of_force, torque, most, assumed))
    if speed_limit is None:
        notes.append(_assumption("speed", of_speed, speed, FASTEST * lever))
    limit = min(torque_limit or torque or SHARE * load, most)
    given = float(model.jnt_user[index, 1]) if model.nuser_jnt > 1 and stiffness is None else 0.0
    if given:
        reduced = _assumption("stiffness", of_stiffness, given, limit / NARROW / lever)
        notes.insert(0, reduced or f"stiffness {given:.3g} {of_stiffness}")
        if not model.dof_armature[model.jnt_dofadr[index]]:
            notes.append("armature assumed")
        given = min(given, limit / NARROW / lever)
    servo = _assumed_servo(
        "model",
        limit,
        min(speed_limit or speed or SPEED * lever, FASTEST * lever),
        load,
        lever,
        "; ".join(filter(None, notes)) or FROM_FILE,
    )
    if not given:
        return servo
    passive = float(model.dof_damping[model.jnt_dofadr[index]])
    damping = float(model.jnt_user[index, 2]) if model.nuser_jnt > 2 else 0.0
    if not damping + passive:
        damping = DAMPING_TIME * given
    damping = max(damping, STABLE * given - passive)
    # Without an armature, a light link with a strong servo is unstable.
    stated = model.dof_armature[model.jnt_dofadr[index]] > 0
    armature = 0.0 if stated else servo.armature
    return replace(servo, stiffness=given, damping=damping, armature=armature)


def _assumption(quantity: str, unit: str, given: float, most: float, how: str = "") -> str:
    """Return why a value differs from the one in the robot's file, or ''."""
    if not given:
        return f"{quantity} assumed{how}"
    if given > most:
        return f"{quantity} reduced: the file's {given:.3g} {unit} is a placeholder"
    return ""


def units_of(model: Any, joint: str) -> tuple[str, str, str, str]:
    """Return 'torque' or 'force', and the units of torque, speed and stiffness of a joint."""
    if sliding(model)[model.joint(joint).id]:
        return "force", "N", "m/s", "N/m"
    return "torque", "N m", "rad/s", "N m/rad"


def _assumed_servo(
    name: str, torque: float, speed: float, load: float, lever: float, source: str
) -> Servo:
    """Return a servo for which only the limits are known; arguments as in `_servo_from_text`."""
    stiffness = max(torque / (BAND * lever), HOLD * load / lever)
    damping = max(torque / speed, DAMPING_TIME * stiffness)
    armature = SPIN_UP * torque / speed
    return Servo(name, torque, speed, 0.0, stiffness, damping, armature, source)
