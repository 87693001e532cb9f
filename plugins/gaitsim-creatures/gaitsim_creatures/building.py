"""Build creatures in MuJoCo, as robots of gaitsim-robot that may crawl."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.plugin.toolkit import Servo
from gaitsim_creatures.modules import Modules
from gaitsim_creatures.plans import place_names
from gaitsim_creatures.trees import BRICK, CORE, HINGE, Floats, Integers
from gaitsim_robot.anatomy import Anatomy, Leg
from gaitsim_robot.simulation import Simulation, build
from gaitsim_robot.terrain import Lattice

TRUNK = "core"
SIDE = 1e-3  # m, distance from the middle plane of hinges on a side
CLEARANCE = 1e-3  # m, height of the lowest point before the body settles
COLOURS = {CORE: (0.25, 0.3, 0.35, 1.0), BRICK: (0.85, 0.6, 0.2, 1.0), HINGE: (0.2, 0.45, 0.7, 1.0)}


def specification(
    modules: Integers, places: Floats, turns: Floats, table: Modules
) -> tuple[Any, tuple[str, ...]]:
    """Return MuJoCo's specification of a body, and the names of its hinges.

    Modules without a hinge between them are one rigid segment. The segment of a hinge's arm, and
    its joint, are named after the hinge's place, the segment with its side.

    Args:
        modules: rows of grown modules, (modules, 6), as in `Bodies`.
        places: middles of the modules, (modules, 3) m.
        turns: axes of the modules, (modules, 3, 3).
        table: sizes and masses.
    """
    import mujoco

    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    box = mujoco.mjtGeom.mjGEOM_BOX
    trunk = spec.worldbody.add_body(name=TRUNK)
    trunk.add_freejoint(name="root")
    names, hinges = place_names(modules), []
    sizes = table.shapes.sizes
    base, arm = np.array(table.hinge.base), np.array(table.hinge.arm)
    # The segment that carries each module's children, its origin and its axes.
    segments = [(trunk, places[0], turns[0])]

    def add(segment: Any, name: str, kind: int, size: Floats, mass: float, at: Floats) -> None:
        body, origin, axes = segment
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, (axes.T @ turn).ravel())
        body.add_geom(
            name=name,
            type=box,
            size=size / 2,
            mass=mass,
            pos=axes.T @ (at - origin),
            quat=quaternion,
            rgba=COLOURS[kind],
        )

    turn = turns[0]
    add(segments[0], TRUNK, CORE, sizes[CORE], table.core.mass, places[0])
    reach = table.reach
    for index in range(1, len(modules)):
        kind, parent, name = int(modules[index, 0]), int(modules[index, 1]), names[index]
        turn, place, carrier = turns[index], places[index], segments[parent]
        if kind == BRICK:
            add(carrier, name, kind, sizes[BRICK], table.brick.mass, place)
            segments.append(carrier)
            continue
        back = place - turn[:, 0] * sizes[HINGE, 0] / 2
        add(
            carrier,
            f"{name} base",
            kind,
            base,
            table.hinge.base_mass,
            back + turn[:, 0] * base[0] / 2,
        )
        anchor = back + turn[:, 0] * base[0]
        body, origin, axes = carrier
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, (axes.T @ turn).ravel())
        moving = body.add_body(
            name=segment_name(name, place), pos=axes.T @ (anchor - origin), quat=quaternion
        )
        moving.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0.0, 1.0, 0.0],
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
            range=[-reach, reach],
        )
        segments.append((moving, anchor, turn))
        hinges.append(name)
        add(segments[-1], name, kind, arm, table.hinge.arm_mass, anchor + turn[:, 0] * arm[0] / 2)
    return spec, tuple(hinges)


def segment_name(name: str, place: Floats) -> str:
    """Return the name of a hinge's segment, such as 'left LF', which gives it the side's colour."""
    side = "left " if place[1] > SIDE else "right " if place[1] < -SIDE else ""
    return f"{side}{name}"


def creature_anatomy(
    modules: Integers, places: Floats, halves: Floats, hinges: Sequence[str], table: Modules
) -> Anatomy:
    """Return the anatomy of a body: each rigid segment is a leg without joints of its own.

    The body length is the largest horizontal extent.
    """
    low = (places - halves).min(axis=0)
    high = (places + halves).max(axis=0)
    extents = high - low
    length = float(extents[:2].max())
    stance = np.zeros(7 + len(hinges))
    stance[2], stance[3] = CLEARANCE - low[2], 1.0
    tip = (table.hinge.arm[0], 0.0, 0.0)
    legs = [Leg(TRUNK, "middle", (), TRUNK, (0.0, 0.0, -table.core.size[2] / 2))]
    middles = places[modules[:, 0] == HINGE]
    for name in map(segment_name, hinges, middles):
        legs.append(Leg(name, "middle", (), name, tip))
    bricks = int((modules[:, 0] == BRICK).sum())
    mass = table.core.mass + bricks * table.brick.mass
    mass += len(hinges) * (table.hinge.base_mass + table.hinge.arm_mass)
    return Anatomy(
        tuple(legs),
        (),
        stance,
        mass,
        length,
        float(extents[0]),
        swing=tuple(hinges),
        crawls=True,
    )


def build_creature(
    modules: Integers,
    places: Floats,
    turns: Floats,
    halves: Floats,
    table: Modules,
    servo: Servo,
    options: Mapping[str, Any],
    lattice: Lattice | None = None,
) -> Simulation:
    """Return the simulation of a body, which lies or stands at rest.

    Args:
        modules: rows of grown modules, (modules, 6), as in `Bodies`.
        places: middles of the modules, (modules, 3) m.
        turns: axes of the modules, (modules, 3, 3).
        halves: half extents of the modules along the axes of the core, (modules, 3) m.
        table: sizes and masses.
        servo: servo of all hinges.
        options: time step, friction and gravity, as arguments of `build`.
        lattice: lattice of uneven ground; None for a level plane.
    """
    spec, hinges = specification(modules, places, turns, table)
    anatomy = creature_anatomy(modules, places, halves, hinges, table)
    servos = dict.fromkeys(hinges, servo)
    return build(spec, anatomy, servos, **options, lattice=lattice)
