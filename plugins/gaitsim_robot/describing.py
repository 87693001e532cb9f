"""Descriptions of a robot, and of the bundled robots and servos."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Facts
from gaitsim.legged import SERVOS, Servo
from gaitsim_robot.anatomy import Anatomy, Leg
from gaitsim_robot.simulation import Simulation


def describe_robot(
    simulation: Simulation, servos: Mapping[str, Servo], world: Mapping[str, str]
) -> Facts:
    """Describe the mass, legs, servos, standing pose, damage and world of a robot.

    Args:
        simulation: simulation of the robot.
        servos: servos of the driven joints by the joints' names.
        world: conditions that are not nominal, by name.
    """
    model, anatomy = simulation.model, simulation.anatomy
    found = {
        "Body": _body(model, anatomy),
        "Legs": {leg.name: _leg(leg) for leg in anatomy.legs},
        "Servos": {**_servos(servos), "standing": _standing(simulation)},
        "Standing pose": _pose(model, anatomy),
    }
    if simulation.damage:
        found["Damage"] = dict.fromkeys(map(str, simulation.damage), "")
    if world:
        found["World"] = dict(world)
    if anatomy.notes:
        found["Notes"] = dict.fromkeys(anatomy.notes, "")
    return found


def describe_library(robots: Mapping[str, Anatomy]) -> Facts:
    """Describe the bundled robots and servos.

    Args:
        robots: anatomies by the robots' names.
    """
    return {
        "Robots: organism.model": {
            name: f"{anatomy.mass:.3g} kg, {len(anatomy.legs)} legs, {len(anatomy.joints)} joints, "
            f"trunk {anatomy.length:.2g} m long"
            for name, anatomy in robots.items()
        },
        "Servos: organism.servo": {
            "model": "the limits in the robot's file",
            **{name: f"{_limits(servo)}. {servo.source}" for name, servo in SERVOS.items()},
            "ideal": "stiff, strong and without delay",
        },
    }


def _body(model: Any, anatomy: Anatomy) -> dict[str, str]:
    driven, held = len(anatomy.joints), len(anatomy.held)
    lines = {
        "mass": f"{anatomy.mass:.4g} kg in {model.nbody - 1} links",
        "trunk": f"{anatomy.length:.3g} m long, {anatomy.stance[2]:.3g} m high when standing",
        "joints": f"{driven} in the legs, moved by gaits",
    }
    if held:
        names = _join_names(anatomy.held, 8)
        lines["held"] = f"{held} outside the legs, held in the standing pose: {names}"
    return lines


def _leg(leg: Leg) -> str:
    sole = f" with a sole of {leg.sole[0]:.2g} × {leg.sole[1]:.2g} m" if any(leg.sole) else ""
    return (
        f"{leg.side}, {leg.length:.3g} m, {len(leg.joints)} joints: {', '.join(leg.joints)}; "
        f"foot {leg.foot}{sole}"
    )


def _servos(servos: Mapping[str, Servo]) -> dict[str, str]:
    """Return the limits of servos; joints with equal servos share a line."""
    groups: dict[str, list[str]] = {}
    for joint, servo in servos.items():
        groups.setdefault(f"{servo.name}: {_limits(servo)}", []).append(joint)
    if len(groups) == 1:
        return {"all": next(iter(groups))}
    return {_join_names(joints, 3): limits for limits, joints in groups.items()}


def _standing(simulation: Simulation) -> str:
    """Describe whether the servos hold the standing pose, and the share of torque it requires."""
    hardest = int(np.argmax(simulation.effort))
    most = f"{simulation.effort[hardest]:.0%} of the torque of {simulation.anatomy.joints[hardest]}"
    if simulation.stands:
        return f"requires up to {most}"
    if simulation.effort[hardest] < 1:
        return (
            f"the robot tips over, although standing requires only {most}; try a different pose "
            "('organism.stance') or stiffer servos ('organism.stiffness')"
        )
    return (
        f"the robot collapses, as standing requires {most}; try a stronger servo "
        "('organism.servo' or 'organism.torque_limit') or a different pose ('organism.stance')"
    )


def _limits(servo: Servo) -> str:
    latency = f", latency {servo.latency * 1000:.0f} ms" if servo.latency else ""
    return f"{servo.stall_torque:.3g} N m, {servo.no_load_speed:.3g} rad/s{latency}"


def _pose(model: Any, anatomy: Anatomy) -> dict[str, str]:
    """Return the standing angle and the range of each leg's joints."""
    lines = {}
    for leg in anatomy.legs:
        angles = []
        for name in leg.joints:
            joint = model.joint(name)
            bounds = anatomy.stance[joint.qposadr[0]], *joint.range
            angle, low, high = (round(math.degrees(bound)) for bound in bounds)
            angles.append(f"{angle}° ({low} to {high}°)")
        lines[leg.name] = ", ".join(angles)
    return lines


def _join_names(names: Sequence[str], most: int) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
