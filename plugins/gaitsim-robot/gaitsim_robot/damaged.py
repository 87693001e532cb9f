"""Damage of a robot: lost legs, stuck joints, and weak or slow servos.

A lost leg keeps its place in all arrays, but has no shape, weight or force. Its joints, and stuck
joints, get a spring and enough armature that no load moves them. Their bodies then move with the
parent bodies, and the solver needs no constraint.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.plugin.toolkit import Damage, Servo
from gaitsim_robot.anatomy import Anatomy, Floats, Leg
from gaitsim_robot.chain import pose_data, sliding
from gaitsim_robot.linkage import ties
from gaitsim_robot.shapes import surfaces

LOCKED = 1e3  # armature of a locked joint, × mass (× length²) of the robot; more costs precision
RETURN = 10.0  # rad/s, natural frequency of a locked joint; weight × length L turns it 1e-4/L rad
WEIGHTLESS = 1e-12  # kg and kg m², just above the values that MuJoCo rejects as errors


def apply_damage(
    spec: Any, anatomy: Anatomy, servos: Mapping[str, Servo], damage: Sequence[Damage]
) -> tuple[Anatomy, dict[str, Servo]]:
    """Damage a robot, and return its anatomy and servos.

    In the standing pose, stuck joints are at their angles and no part is below the ground. The
    contact point of a lost foot is where its leg was attached.

    Args:
        spec: MuJoCo's specification of the robot without servos and ground, changed in place.
        anatomy: anatomy of the intact robot.
        servos: servos of its driven joints by the joints' names.
        damage: damage to its legs and joints.
    """
    model = spec.compile()
    lost = lost_bodies(model, anatomy, damage)
    stance = _stance(model, anatomy, damage, lost)
    of_lost = [model.joint(i).name for i in range(1, model.njnt) if model.jnt_bodyid[i] in lost]
    stuck = [one.part for one in damage if is_stuck(one)]
    for body in lost:
        _remove(spec, model.body(body).name)
    for name in (*of_lost, *stuck):
        joint = model.joint(name)
        squared = 1.0 if sliding(model)[joint.id] else anatomy.length**2
        angle = float(stance[joint.qposadr[0]])
        _lock(spec.joint(name), angle, LOCKED * anatomy.mass * squared)
    _deactivate_constraints(spec, model, of_lost, lost)
    weaker = {
        one.part: _damaged_servo(servos[one.part], one) for one in damage if one.part in servos
    }
    without_force = {
        name: replace(servos[name], stall_torque=0.0) for name in of_lost if name in servos
    }
    impaired = replace(
        anatomy,
        legs=_legs(model, anatomy, stance, lost),
        stance=stance,
        mass=anatomy.mass - float(model.body_mass[sorted(lost)].sum()),
    )
    return impaired, {**servos, **weaker, **without_force}


def lost_bodies(model: Any, anatomy: Anatomy, damage: Sequence[Damage]) -> set[int]:
    """Return the indices of the bodies of lost legs."""
    lost = {one.part for one in damage if one.kind == "lost"}
    legs = [leg for leg in anatomy.legs if leg.name in lost]
    bodies = {int(model.joint(joint).bodyid[0]) for leg in legs for joint in leg.joints}
    for body in range(1, model.nbody):  # parents before children
        if int(model.body_parentid[body]) in bodies:
            bodies.add(body)
    return bodies


def is_stuck(damage: Damage) -> bool:
    """Return whether the damage stops a joint from turning."""
    return damage.kind == "stuck" or (damage.kind == "slow" and damage.value == 0)


def _damaged_servo(servo: Servo, damage: Damage) -> Servo:
    if damage.kind == "weak" and damage.value:
        return replace(servo, stall_torque=servo.stall_torque * damage.value)
    if damage.kind == "slow" and damage.value:
        return replace(servo, no_load_speed=servo.no_load_speed * damage.value)
    return replace(servo, stall_torque=0.0)


def _remove(spec: Any, name: str) -> None:
    """Remove the shapes and the weight of a body."""
    body = spec.body(name)
    for geom in body.geoms:
        spec.delete(geom)
    body.mass = WEIGHTLESS
    body.fullinertia = np.full(6, np.nan)
    body.inertia = np.full(3, WEIGHTLESS)


def _lock(joint: Any, angle: float, armature: float) -> None:
    """Hold a joint at an angle, rad."""
    import mujoco

    joint.armature = armature
    joint.springref = angle
    joint.stiffness[0] = RETURN**2 * armature
    joint.damping[0] = 2 * RETURN * armature
    joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    joint.frictionloss = 0.0


def _deactivate_constraints(spec: Any, model: Any, joints: Sequence[str], lost: set[int]) -> None:
    """Deactivate the mimic joints, closed linkages and taut tendons of lost legs."""
    import mujoco

    ids = {model.joint(name).id for name in joints}
    taut = [name for name, tie in ties(model).items() if tie.keys() & ids]
    sites = [site.name for site in spec.sites if site.parent.id in lost]
    kinds = {mujoco.mjtEq.mjEQ_JOINT: joints, mujoco.mjtEq.mjEQ_TENDON: taut}
    for constraint in spec.equalities:
        gone = kinds.get(constraint.type, sites)
        if constraint.name1 in gone or constraint.name2 in gone:
            constraint.active = 0


def _stance(model: Any, anatomy: Anatomy, damage: Sequence[Damage], lost: set[int]) -> Floats:
    """Return the standing pose with stuck joints and the lowest point at z = 0, (nq,)."""
    stance = anatomy.stance.copy()
    angles = {one.part: one.value for one in damage if one.kind == "stuck"}
    for name, angle in angles.items():
        if angle is not None:
            stance[model.joint(name).qposadr[0]] = angle
    if angles:
        surface = surfaces(model)
        low = surface.place(pose_data(model, stance))[:, 2] - surface.radius
        stance[2] -= low[~np.isin(surface.bodies, sorted(lost))].min()
    return stance


def _legs(model: Any, anatomy: Anatomy, stance: Floats, lost: set[int]) -> tuple[Leg, ...]:
    """Return the legs; the point of a lost foot is the hip, in the foot's frame."""
    data = pose_data(model, stance)
    legs = []
    for leg in anatomy.legs:
        foot = model.body(leg.foot).id
        if foot in lost:
            away = data.xanchor[model.joint(leg.joints[0]).id] - data.xpos[foot]
            x, y, z = (data.xmat[foot].reshape(3, 3).T @ away).tolist()
            leg = replace(leg, point=(x, y, z))  # noqa: PLW2901
        legs.append(leg)
    return tuple(legs)
