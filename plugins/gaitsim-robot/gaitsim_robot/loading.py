"""Load robots by name, file or text, cache everything derived from them, and describe them."""

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np

from gaitsim.plugin import BodyFile, Facts, nearest, unknown
from gaitsim.plugin.toolkit import SERVOS, Damage, Servo
from gaitsim_robot.anatomy import Anatomy, Facing, Leg
from gaitsim_robot.chain import sliding
from gaitsim_robot.conditions import apply_world
from gaitsim_robot.designs import MASS_PER_TORQUE, DesignSpace
from gaitsim_robot.encodings import Encoding, Kind, Symmetry
from gaitsim_robot.errors import RobotError, shorten
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.importing import import_robot
from gaitsim_robot.servos import FROM_FILE, ServoName, joint_servos, units_of
from gaitsim_robot.simulation import Simulation, build
from gaitsim_robot.terrain import Lattice, lattice_for
from gaitsim_robot.text import compile_model, disable_log, trust

SPEED_SHARE = 0.8  # speed limit of commands as a share of a servo's no-load speed
REMEMBERED = 16  # imported files
BUNDLED = ("quadruped", "hexapod", "spider-physics")

ServoOptions = tuple[ServoName, float | None, float | None, float | None, float | None]
"""Options of the servos: name, torque limit, speed limit, latency and stiffness."""


def robot_text(
    model: str,
    folder: Path | None,
    roots: tuple[Path, ...] = (),
    *,
    scale: float = 1.0,
    mass_scale: float = 1.0,
) -> str:
    """Return the option `model` in the form that an experiment stores: bundled name or text.

    Args:
        model: name of a bundled robot, a robot's text, or the path of a file.
        folder: base of relative paths; None forbids files.
        roots: additional folders that a file may refer to.
        scale: factor for the lengths of a file.
        mass_scale: factor for the masses of a file.
    """
    is_text = model.lstrip().startswith("<")
    if (is_text or model in BUNDLED) and (scale, mass_scale) != (1, 1):
        option = "scale" if scale != 1 else "mass_scale"
        source = "a text that was already read" if is_text else f"bundled: {model!r}"
        raise RobotError(
            f"{option} converts the units of a robot's file, but the model is {source}",
            key=option,
            remedy="set organism.model to the path of the file, too",
        )
    if model in BUNDLED:
        return model
    if is_text:
        compile_model(model)
        return model
    if folder is None or not model:
        raise RobotError(
            f"there is no bundled robot {model!r}",
            allowed=f"{', '.join(BUNDLED)}, or a robot's text",
        )
    path = folder / model
    # Check before starting a child process; unlike Path, os.path accepts invalid names, too.
    if not os.path.isfile(path):  # noqa: PTH113
        raise RobotError(
            f"there is neither a bundled robot nor a file {model[:200]!r}",
            allowed=f"{', '.join(BUNDLED)}, or the path of a URDF or MJCF file",
            remedy=nearest(model, BUNDLED),
        )
    status = path.stat()
    # A form in the terminal UI checks its options at every keystroke.
    key = (path.absolute(), status.st_mtime_ns, status.st_size, roots, scale, mass_scale)
    found = _imported.get(key) or import_robot(path, roots, scale=scale, mass_scale=mass_scale)
    _imported[key] = found
    if len(_imported) > REMEMBERED:
        _imported.pop(next(iter(_imported)), None)
    return found.text


_imported: dict[tuple[Any, ...], BodyFile] = {}  # the last files, by path, change and options


def imported_file(text: str) -> BodyFile | None:
    """Return the file from which this process recently imported a robot's text, or None."""
    return next((file for file in tuple(_imported.values()) if file.text == text), None)


@lru_cache(maxsize=16)
def bundled_text(name: str) -> str:
    """Return the text of a bundled robot."""
    text = (files("gaitsim_robot") / "models" / f"{name}.xml").read_text(encoding="utf-8")
    trust(text)  # avoids a child process at every start
    return text


@lru_cache(maxsize=16)
def load_anatomy(
    text: str,
    feet: tuple[str, ...],
    stance: tuple[tuple[str, float], ...],
    facing: Facing,
    swing: tuple[str, ...] = (),
    rolls: bool = False,
) -> Anatomy:
    """Return the anatomy of a robot's text with the options of the body.

    `stance` is in degrees, and for slides in metres.
    """
    if swing or rolls:
        still = load_anatomy(text, feet, stance, facing)
        if rolls and not still.wheels:
            raise RobotError(
                "no leg ends in a wheel with a motor",
                key="wheels",
                remedy="set organism.wheels to 'hold'",
            )
        rolling = still.wheels if rolls else ()
        for name in swing:
            if name not in still.held:
                raise unknown("held joint", name, still.held, key="swing")
        held = tuple(name for name in still.held if name not in (*swing, *rolling))
        return replace(still, held=held, swing=swing, rolling=rolling)
    model = compile_model(text)
    slides = {model.joint(int(index)).name for index in np.flatnonzero(sliding(model))}
    pose = {name: at if name in slides else math.radians(at) for name, at in stance}
    return find_anatomy(model, feet, pose or None, facing)


def joint_ranges(text: str, anatomy: Anatomy) -> tuple[tuple[float, float], ...]:
    """Return the smallest and largest angle of each leg joint, rad."""
    model = compile_model(text)
    return tuple(
        (-math.inf, math.inf)
        if name in anatomy.rolling
        else tuple(model.joint(name).range.tolist())
        for name in anatomy.joints
    )


Servos = tuple[tuple[str, Servo], ...]
"""Servos by the names of their joints."""

CompilationInput = tuple[str, Anatomy, Servos, float, float, float, tuple[Damage, ...]]
"""Input of the compilation: text, anatomy, servos, time step, friction, gravity and damage."""

_compilation = RLock()  # keeps threads from compiling the same world at the same time


def load_simulation(
    compiled: CompilationInput,
    world: tuple[tuple[str, float], ...],
    seconds: float,
    horns: tuple[float, ...] = (),
) -> Simulation:
    """Return a robot in a world.

    Args:
        compiled: input of the compilation.
        world: conditions, sorted by name.
        seconds: duration for which uneven ground is large enough, s.
        horns: constant error of each leg joint, (joints,) rad; () for none.
    """
    lattice = lattice_for(dict(world), seconds)
    with _compilation:
        if not world and not horns:
            return _nominal_simulation(*compiled)
        return _simulation_in_world(compiled, world, lattice, horns)


@lru_cache(maxsize=64)  # a report of adaptations alternates between many damaged robots
def _nominal_simulation(
    text: str,
    anatomy: Anatomy,
    servos: Servos,
    dt: float,
    friction: float,
    gravity: float,
    damage: tuple[Damage, ...],
    lattice: Lattice | None = None,
) -> Simulation:
    world = {"friction": friction, "gravity": gravity}
    spec = load_specification(text)
    return build(spec, anatomy, dict(servos), dt=dt, **world, damage=damage, lattice=lattice)


@lru_cache(maxsize=32)  # 0.3 MB for each bundled robot; a run uses fewer worlds
def _simulation_in_world(
    compiled: CompilationInput,
    world: tuple[tuple[str, float], ...],
    lattice: Lattice | None,
    horns: tuple[float, ...],
) -> Simulation:
    nominal = _nominal_simulation(*compiled, lattice) if lattice else _nominal_simulation(*compiled)
    return apply_world(nominal, dict(world), np.array(horns) if horns else None)


def servo_latency(servo: ServoOptions) -> float:
    """Return the latency of servos, s."""
    name, _, _, latency, _ = servo
    if latency is not None:
        return latency
    return SERVOS[name].latency if name in SERVOS else 0.0


@lru_cache(maxsize=16)
def load_servos(
    text: str, anatomy: Anatomy, servo: ServoOptions, factor: float = 1.0
) -> dict[str, Servo]:
    """Return the servo of each driven joint by the joint's name, with a factor of its torque."""
    servos = joint_servos(compile_model(text), anatomy, *servo)
    return {name: one.scaled(factor) for name, one in servos.items()}


@lru_cache(maxsize=16)
def load_designs(text: str, anatomy: Anatomy, servo: ServoOptions, growth: float) -> DesignSpace:
    """Return the dimensions of a robot, and its designs."""
    servos = load_servos(text, anatomy, servo)
    torque = float(np.mean([one.stall_torque for one in servos.values()]))
    mass = SERVOS[servo[0]].mass if servo[0] in SERVOS else MASS_PER_TORQUE * torque
    return DesignSpace(text, anatomy, torque if servo[0] != "ideal" else 0.0, mass, growth)


@lru_cache(maxsize=16)
def load_encoding(
    simulation: Simulation,
    kind: Kind,
    symmetry: Symmetry,
    fastest: float,
    heading: float,
    walks: bool = True,
) -> Encoding:
    """Return the encoding of a robot, whose commands stay below the speed of its servos."""
    top_speed = SPEED_SHARE * simulation.top_speed
    return Encoding(
        simulation.model, simulation.anatomy, top_speed, kind, symmetry, fastest, heading, walks
    )


def load_specification(text: str) -> Any:
    """Return MuJoCo's specification of a robot's text."""
    import mujoco

    disable_log()
    return mujoco.MjSpec.from_string(text)


def describe_robot(
    simulation: Simulation, servos: Mapping[str, Servo], world: Mapping[str, str]
) -> Facts:
    """Describe the mass, legs, servos, standing pose, damage and world of a robot."""
    model, anatomy = simulation.model, simulation.anatomy
    found = {
        "Body": _body(model, anatomy),
        "Legs": {leg.name: _leg(leg) for leg in anatomy.legs},
        "Servos": {**_servos(model, servos), "standing": _standing(simulation)},
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
    """Describe the bundled robots and servos."""
    return {
        "Robots: organism.model": {
            name: f"{anatomy.mass:.3g} kg, {len(anatomy.legs)} legs, {len(anatomy.joints)} joints, "
            f"trunk {anatomy.trunk:.2g} m long"
            for name, anatomy in robots.items()
        },
        "Servos: organism.servo": {
            "model": "the limits in the robot's file",
            **{name: f"{_limits(servo)}. {servo.source}" for name, servo in SERVOS.items()},
            "ideal": "stiff, strong and without delay",
        },
    }


def _body(model: Any, anatomy: Anatomy) -> dict[str, str]:
    driven, held = sum(len(leg.joints) for leg in anatomy.legs), len(anatomy.held)
    lines = {
        "mass": f"{anatomy.mass:.4g} kg in {model.nbody - 1} links",
        "trunk": f"{anatomy.trunk:.3g} m long, {anatomy.stance[2]:.3g} m high when standing",
        "joints": f"{driven} in the legs, moved by gaits",
    }
    if anatomy.swing:
        names = shorten(anatomy.swing, 8)
        lines["swing"] = f"{len(anatomy.swing)} outside the legs, swung by gaits: {names}"
    if anatomy.wheels:
        how = "roll" if anatomy.rolling else "are held, as organism.wheels is 'hold'"
        lines["wheels"] = f"{shorten(anatomy.wheels, 8)} {how}"
    if held:
        names = shorten(anatomy.held, 8)
        lines["held"] = f"{held} outside the legs, held in the standing pose: {names}"
    if anatomy.passive:
        names = shorten(anatomy.passive, 8)
        lines["passive"] = f"{len(anatomy.passive)} without a motor: {names}"
    return lines


def _leg(leg: Leg) -> str:
    sole = f" with a sole of {leg.sole[0]:.2g} × {leg.sole[1]:.2g} m" if any(leg.sole) else ""
    return (
        f"{leg.side}, {leg.length:.3g} m, {len(leg.joints)} joint{'s' * (len(leg.joints) > 1)}: "
        f"{', '.join(leg.joints)}; "
        f"foot {leg.foot}{sole}"
    )


def _servos(model: Any, servos: Mapping[str, Servo]) -> dict[str, str]:
    """Return the limits of servos; joints with equal servos share a line."""
    groups: dict[str, list[str]] = {}
    for joint, servo in servos.items():
        exact = servo.name != "model" or servo.source == FROM_FILE
        source = "" if exact else f" ({servo.source})"
        limits = _limits(servo, *units_of(model, joint)[1:3])
        groups.setdefault(f"{servo.name}: {limits}{source}", []).append(joint)
    if len(groups) == 1:
        return {"all": next(iter(groups))}
    return {shorten(joints, 3): limits for limits, joints in groups.items()}


def _standing(simulation: Simulation) -> str:
    """Describe whether the servos hold the standing pose, and the share of torque it requires."""
    hardest = int(np.argmax(simulation.effort))
    joint = simulation.anatomy.joints[hardest]
    kind = units_of(simulation.model, joint)[0]
    most = f"{simulation.effort[hardest]:.0%} of the {kind} of {joint}"
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


def _limits(servo: Servo, torque: str = "N m", speed: str = "rad/s") -> str:
    latency = f", latency {servo.latency * 1000:.0f} ms" if servo.latency else ""
    rating = servo.continuous * servo.stall_torque
    continuous = f" ({rating:.2g} continuous)" if rating else ""
    limits = f"{servo.stall_torque:.3g} {torque}{continuous}, {servo.no_load_speed:.3g} {speed}"
    return f"{limits}{latency}"


def _pose(model: Any, anatomy: Anatomy) -> dict[str, str]:
    """Return the standing angle and the range of each leg's joints."""
    lines = {}
    for leg in anatomy.legs:
        angles = []
        for name in leg.joints:
            joint = model.joint(name)
            bounds = np.array([anatomy.stance[joint.qposadr[0]], *joint.range])
            slides = sliding(model)[joint.id]
            shown = bounds * 1000 if slides else np.degrees(bounds)
            (angle, low, high), unit = map(round, shown.tolist()), " mm" if slides else "°"
            angles.append(f"{angle}{unit} ({low} to {high}{unit})")
        lines[leg.name] = ", ".join(angles)
    return lines
