"""Questions about guesses from a robot's file, with the options that answer them."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.plugin import Question
from gaitsim.plugin.toolkit import Servo
from gaitsim_robot.anatomy import Anatomy
from gaitsim_robot.chain import sliding
from gaitsim_robot.servos import units_of
from gaitsim_robot.units import LENGTH_UNITS, MASS_UNITS, likely_units, unit_warning

ORDER = (
    "scale", "mass_scale", "feet", "facing", "motors", "torque_limit", "speed_limit", "stiffness",
    "stance",
)  # fmt: skip
"""Options, those that waste most if wrong first."""


def ask(model: Any, anatomy: Anatomy, servos: Mapping[str, Servo]) -> tuple[Question, ...]:
    """Return the questions about a robot, the costliest mistakes first.

    Args:
        model: MuJoCo's model of the robot's text.
        anatomy: anatomy of the robot.
        servos: servos by the names of their joints.
    """
    found = [*_units(anatomy), *_guesses(model, anatomy), *_servos(model, anatomy, servos)]
    if not model.nu:  # otherwise the text states the motors
        text = f"Do all {model.njnt - 1} joints have motors? The file states none"
        found.append(Question(text, "motors", '["all"]'))
    return tuple(sorted(found, key=lambda one: ORDER.index(one.option)))


def _units(anatomy: Anatomy) -> list[Question]:
    if not unit_warning(anatomy.length, anatomy.mass):
        return []
    size = f"The robot is {anatomy.length:.4g} m long and weighs {anatomy.mass:.4g} kg"
    scales, mass_scales = (
        [factor for factor in factors if factor != 1]
        for factors in likely_units(anatomy.length, anatomy.mass)
    )
    if not scales and not mass_scales:
        return [Question(f"{size}: is its file in other units?", "scale", "0.001")]
    kinds = (
        ("lengths", "scale", scales, LENGTH_UNITS),
        ("masses", "mass_scale", mass_scales, MASS_UNITS),
    )
    return [
        Question(f"{size}: are {kind} in its file in {units[one]}?", option, f"{one:g}")
        for kind, option, factors, units in kinds
        for one in factors[:1]
    ]


def _guesses(model: Any, anatomy: Anatomy) -> list[Question]:
    """Return the questions about legs, nose and standing pose."""
    found = []
    if anatomy.doubt:
        feet = [leg.foot for leg in anatomy.legs]
        found.append(Question(anatomy.doubt, "feet", _list(feet)))
    if anatomy.guessed_facing:
        facing = anatomy.guessed_facing
        text = f"Does the nose point along {facing} in the file? Only the shape suggests it"
        found.append(Question(text, "facing", facing))
    if anatomy.searched:
        angles = ", ".join(
            f"{_key(name)} = {_standing(model, anatomy, name):g}" for name in anatomy.joints
        )
        text = "Is the standing pose right (see --picture)? gaitsim searched for it"
        found.append(Question(text, "stance", f"{{ {angles} }}"))
    return found


def _servos(model: Any, anatomy: Anatomy, servos: Mapping[str, Servo]) -> list[Question]:
    """Return the questions about values that the servos of all legs lack in the file.

    No option answers those about slides.
    """
    found = []
    turning = [name for name in anatomy.joints if units_of(model, name)[0] == "torque"]
    for quantity, option, attribute, unit in (
        ("torque", "torque_limit", "stall_torque", "N m"),
        ("speed", "speed_limit", "no_load_speed", "rad/s"),
        ("stiffness", "stiffness", "stiffness", "N m/rad"),
    ):
        notes = {_note(servos[joint], quantity) for joint in turning}
        values = {f"{getattr(servos[joint], attribute):.3g}" for joint in turning}
        if "" in notes or len(values) != 1:
            continue
        value, note = values.pop(), sorted(notes)[0]
        reason = note.partition(": ")[2] if "reduced" in note else "the file states none"
        if quantity == "torque":
            reason += "; 'organism.servo' names hobby servos"
        text = f"Do the servos have a {quantity} of {value} {unit}? Assumed, as {reason}"
        found.append(Question(text, option, value))
    return found


def _note(servo: Servo, quantity: str) -> str:
    """Return why a quantity of a servo is not that of the robot's file, or ''."""
    starts = f"{quantity} assumed", f"{quantity} reduced"
    return next((note for note in servo.source.split("; ") if note.startswith(starts)), "")


def _standing(model: Any, anatomy: Anatomy, name: str) -> float:
    """Return the standing angle of a joint, rounded to 0.1°, or 0.1 mm, within its limits."""
    joint = model.joint(name)
    unit, parts = (10_000, 10_000) if sliding(model)[joint.id] else (10, math.degrees(10))
    low, high = parts * joint.range
    steps = round(parts * anatomy.stance[joint.qposadr[0]])
    return float(np.clip(steps, math.ceil(low), math.floor(high))) / unit + 0.0


def _list(names: Sequence[str]) -> str:
    return json.dumps(names, ensure_ascii=False)


def _key(name: str) -> str:
    """Return a name as a key of TOML."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)
