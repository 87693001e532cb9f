"""The body `creature`: a tree of buildable modules, which evolves together with its movement."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import ValidationInfo, model_validator

from gaitsim.plugin import (
    PRESENT,
    PRESENT_CHANNEL,
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Facts,
    Genomes,
    GenomeSpace,
    Measure,
    Motion,
    Organism,
    Rig,
    Skeleton,
    check_world,
    folder_of,
    option,
)
from gaitsim.plugin.toolkit import (
    GeneGroup,
    Servo,
    angles_frequency,
    check_joint_angles,
    check_time_step,
    genome_space,
    sin,
    split_genomes,
)
from gaitsim_creatures.building import build_creature, specification
from gaitsim_creatures.measures import creature_measures, describe_bodies
from gaitsim_creatures.modules import load_modules, modules_text
from gaitsim_creatures.plans import (
    grow_plan,
    parse_plan,
    place_names,
    plan_text,
    published,
)
from gaitsim_creatures.trees import (
    AMPLITUDE,
    ANTIPHASE,
    FREQUENCY,
    HEAD,
    HINGE,
    OFFSET,
    PHASE,
    SYMMETRY,
    TWO_PI,
    WIDTH,
    Bodies,
    Floats,
    Symmetry,
    TreeSpace,
)
from gaitsim_robot.conditions import apply_world, robot_checks, robot_conditions
from gaitsim_robot.organism import CHANNELS, MUJOCO, physics
from gaitsim_robot.simulation import FRAME_RATE, Simulation
from gaitsim_robot.terrain import lattice_for
from gaitsim_robot.text import with_servos

EVOLVE = "evolve"
SPEED_SHARE = 0.8  # speed limit of commands as a share of a servo's no-load speed
START = 0.5  # s, time over which the movement starts
SLOWEST = 0.2  # Hz
NO_HINGES = "the body has no hinge that moves it"

OWN: Mapping[str, Channel] = {
    **CHANNELS,
    PRESENT: PRESENT_CHANNEL,
}
TREE: Mapping[str, Channel] = {
    "tree": Channel(("genes",), "", "genes, from which the individual's body grows")
}
"""The channel of a body that evolves, besides the others."""


class _CreatureChannels:
    """The channels of a creature; the class itself shows all that creatures may have."""

    def __get__(self, creature: "Creature | None", owner: type) -> Mapping[str, Channel]:
        fixed = creature is not None and creature.body != EVOLVE
        return OWN if fixed else {**OWN, **TREE}


class Creature(Organism):
    """A tree of buildable modules: a core, bricks, and hinges with servos that swing.

    Sims 1994, "Evolving virtual creatures"; the modules are those of Auerbach et al. 2014,
    "RoboGen", and of its successors.
    """

    body: str = option(
        EVOLVE,
        "'evolve' for a body of each individual's own; a published body ('gecko', 'spider', "
        "'snake'); or a plan such as 'L hinge, LF brick, R hinge, RF brick'",
    )
    modules: str = option(
        "revolve2",
        "sizes, masses and servo of the modules: 'revolve2', 'robogen', 'ariel', or the path of a "
        "TOML file like those",
    )
    most: int = option(
        20, "largest number of modules of a body that evolves, besides its core", ge=1, le=100
    )
    largest: float = option(
        1.0,
        "largest extent of a body that evolves, along an axis of its core",
        unit="m",
        gt=0.05,
        le=20,
    )
    symmetry: Symmetry = option(
        "gene",
        "whether the right side of a body that evolves mirrors the left: 'gene' leaves it to "
        "evolution",
    )
    fastest: float = option(
        1.5, "highest frequency of the hinges' oscillators", unit="Hz", gt=SLOWEST, le=5
    )
    duration: float = option(10.0, "length of a rollout", unit="s", ge=0.5, le=600)
    dt: float = option(
        0.004,
        "time step of the physics; 1/50 s must be a whole multiple of it",
        unit="s",
        ge=2e-4,
        le=0.01,
    )
    servo: Literal["modules", "ax-12a", "sts3215", "mg995", "xl430-w250"] = option(
        "modules",
        "servo of the hinges: 'modules' is the one in the table of modules, the others are hobby "
        "servos with values from their data sheets",
    )
    engine: str = option(
        MUJOCO, "physics engine: 'mujoco', or 'bullet' (PyBullet) with the package gaitsim-bullet"
    )
    friction: float = option(0.8, "coefficient of friction of modules on the ground", ge=0, le=5)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)
    world: dict[str, float] = option({}, WORLD_HELP)

    dynamic: ClassVar[bool] = True
    channels: ClassVar[Any] = _CreatureChannels()

    @model_validator(mode="after")
    def _check(self, info: ValidationInfo) -> Self:
        """Replace the path of a table of modules by its text, and check the body."""
        check_time_step(self.dt, FRAME_RATE)
        physics(self.engine)
        text = modules_text(self.modules, folder_of(info, "modules"))
        object.__setattr__(self, "modules", text)  # the model is frozen
        if self.body != EVOLVE:
            _ = self._plan
        check_world(self.world, self.conditions())
        return self

    @property
    def threads(self) -> bool:  # type: ignore[override]
        """Whether the engine releases the interpreter's lock; PyBullet does not."""
        return self.engine == MUJOCO

    @property
    def frames(self) -> int:
        """Number of frames of a rollout, including the start."""
        return round(self.duration * FRAME_RATE) + 1

    @property
    def _plan(self) -> Bodies:
        """The body of a plan, a population of one."""
        return _planned(self.body, self.modules)

    @property
    def _servo(self) -> Servo:
        return load_modules(self.modules).motor(self.servo)

    @property
    def _tree_space(self) -> TreeSpace:
        table = load_modules(self.modules)
        frequencies = (SLOWEST, self.fastest)
        sizes = table.shapes, self.largest, table.reach
        return TreeSpace(self.most, *sizes, frequencies, self.symmetry)

    @property
    def _groups(self) -> tuple[GeneGroup, ...]:
        """The genes of a body that does not evolve."""
        hinges, reach = self.joint_names(), load_modules(self.modules).reach
        return (
            GeneGroup("frequency", ("",), SLOWEST, self.fastest),
            GeneGroup("amplitude", hinges, 0.0, reach),
            GeneGroup("phase", hinges, 0.0, TWO_PI, periodic=True),
            GeneGroup("offset", hinges, -reach, reach),
        )

    def genome_space(self) -> GenomeSpace:
        """Return the space of trees, or of the oscillators of a body that does not evolve."""
        return self._tree_space if self.body == EVOLVE else genome_space(self._groups)

    def joint_names(self) -> tuple[str, ...]:
        """Return the places of the hinges; for bodies that evolve, 'hinge 1' and so on."""
        if self.body == EVOLVE:
            return tuple(f"hinge {number}" for number in range(1, self.most + 1))
        return _hinges(self._plan)

    def move(self, genomes: Genomes) -> Motion:
        """Simulate each individual with its own body; hinges that it lacks do not move."""
        if self.body != EVOLVE:
            bodies, count = self._plan, len(genomes)
            frequency, amplitude, phase, offset = split_genomes(genomes, self._groups)
            return self._walk(
                [0] * count, bodies, frequency[:, 0], np.stack([amplitude, phase, offset], axis=-1)
            )
        bodies = self._tree_space.grow(genomes)
        oscillators = np.zeros((len(genomes), self.most, 3))
        for index in range(len(genomes)):
            found = _oscillators(genomes[index], bodies, index)
            oscillators[index, : len(found)] = found
        rows = range(len(genomes))
        motion = self._walk(rows, bodies, genomes[:, FREQUENCY], oscillators)
        motion.add("tree", genomes.copy())
        return motion

    def _walk(
        self, rows: Sequence[int], bodies: Bodies, frequency: Floats, oscillators: Floats
    ) -> Motion:
        """Simulate individuals with oscillators, (population, joints, 3).

        Args:
            rows: row of each individual's body.
            bodies: grown bodies.
            frequency: frequency of the oscillators, (population,) Hz.
            oscillators: amplitude, phase and offset of each hinge, rad.
        """
        times = np.arange(self.frames) / FRAME_RATE
        amplitude, phase, offset = np.moveaxis(oscillators[:, None], -1, 0)
        cycles = TWO_PI * frequency[:, None] * times
        # Faster commands would only be cut off by the servo.
        fastest = SPEED_SHARE * self._servo.no_load_speed / (TWO_PI * frequency[:, None, None])
        amplitude = np.minimum(amplitude, fastest)
        angles = offset + amplitude * sin(cycles[..., None] + phase)
        reach = load_modules(self.modules).reach
        angles = np.clip(angles * np.minimum(times / START, 1.0)[:, None], -reach, reach)
        return self._follow(rows, bodies, angles, frequency)

    def _follow(
        self, rows: Sequence[int], bodies: Bodies, angles: Floats, frequency: Floats
    ) -> Motion:
        """Simulate individuals whose hinges follow angles, (population, frames, joints).

        Individuals with the same body share a rollout. Others cannot: MuJoCo's rollout has one
        `MjData`, whose sizes follow from the tree of the body.
        """
        from gaitsim_robot.rollout import walk

        simulations = [self._simulation(bodies, row) for row in rows]
        shared = {id(one): one for one in simulations}
        present = np.zeros((len(rows), len(self.joint_names())), np.bool_)
        channels: dict[str, Array] = {PRESENT: present}
        failures: dict[int, str] = {}
        for key, simulation in shared.items():
            members = np.array([row for row, one in enumerate(simulations) if id(one) == key])
            joints = len(simulation.ctrl)
            present[members, :joints] = True
            engine = physics(self.engine).roll_out if joints else _lie
            commands = angles[members, :, :joints]
            moved = walk(simulation, commands, engine, frequency[members])
            failures |= {int(members[row]): reason for row, reason in moved.failures.items()}
            for name in moved:
                self._fill(channels, name, len(rows), members, moved[name])
        return Motion(FRAME_RATE, channels, failures=failures)

    def _fill(
        self, channels: dict[str, Array], name: str, count: int, members: Array, values: Array
    ) -> None:
        """Write the values of some individuals into a channel, which is padded with zeros."""
        most = len(self.joint_names())
        lengths = {"joints": most, "feet": most + 1, "coordinates": most + 7}
        axes = CHANNELS[name].axes
        shape = [
            lengths[axis] if isinstance(axis, str) and axis in lengths else length
            for axis, length in zip(axes, values.shape[1:], strict=True)
        ]
        if name not in channels:
            channels[name] = np.zeros((count, *shape), values.dtype)
        channels[name][np.ix_(members, *map(np.arange, values.shape[1:]))] = values

    def _simulation(self, bodies: Bodies, row: int) -> Simulation:
        count = int(bodies.counts[row])
        modules = bodies.modules[row, :count].copy()
        modules[:, 4:] = 0  # nodes and copies do not change the body
        return _load_simulation(
            modules.tobytes(),
            bodies.places[row, :count].tobytes(),
            bodies.turns[row, :count].tobytes(),
            bodies.halves[row, :count].tobytes(),
            self.modules,
            self._servo,
            (("dt", self.dt), ("friction", self.friction), ("gravity", self.gravity)),
            tuple(sorted(self.world.items())),
            self.duration,
        )

    @property
    def simulation(self) -> Simulation:
        """The body of a plan in its world."""
        return self._simulation(self._plan, 0)

    def embody(self, genome: Genomes) -> tuple[Self, Genomes]:
        """Return the body of an individual as a plan, and the genes of its oscillators."""
        if self.body != EVOLVE:
            return self, genome
        bodies = self._tree_space.grow(genome[None])
        modules = bodies.modules[0, : bodies.counts[0]]
        if len(modules) == 1:  # a core without modules has no plan
            return self, genome
        own = self.model_copy(update={"body": plan_text(modules)})
        found = _oscillators(genome, bodies, 0)
        return own, np.concatenate([genome[:1], found.T.ravel()])

    def play(self, joint_angles: Array) -> Motion:
        """Move the body of a plan with the given commands, clipped to the reach of the hinges."""
        if self.body == EVOLVE:
            return super().play(joint_angles)  # an error
        check_joint_angles(joint_angles, len(self.joint_names()))
        reach = load_modules(self.modules).reach
        angles = np.clip(joint_angles.astype(np.float64), -reach, reach)
        frequency = angles_frequency(angles, FRAME_RATE)
        return self._follow([0] * len(angles), self._plan, angles, frequency)

    @property
    def can_play(self) -> bool:
        """Whether the body is a plan, as angles of others say nothing about their body."""
        return self.body != EVOLVE

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the modules, and the segments from hinge to hinge."""
        from gaitsim_robot.skeleton import skeleton

        if self.body != EVOLVE:
            bodies = self._plan
        else:
            bodies = self._tree_space.grow(motion["tree"][individual : individual + 1])
        simulation = self._simulation(bodies, 0)
        joints = len(simulation.ctrl)
        own = {
            "configuration": motion["configuration"][individual : individual + 1, :, : 7 + joints],
            "stance": motion["stance"][individual : individual + 1, :, : 1 + joints],
        }
        return skeleton(simulation, Motion(motion.frame_rate, own), 0)

    def rig(self) -> Rig | None:
        """Return the tree of segments; None for bodies that evolve."""
        from gaitsim_robot.skeleton import rig

        if self.body == EVOLVE:
            return None
        simulation = self.simulation
        return rig(simulation.model, simulation.anatomy)

    def mjcf(self) -> str:
        """Return the body of a plan as MJCF with its servos; '' for bodies that evolve."""
        if self.body == EVOLVE:
            return ""
        bodies, table = self._plan, load_modules(self.modules)
        spec, hinges = specification(bodies.modules[0], bodies.places[0], bodies.turns[0], table)
        spec.compile()
        return with_servos(spec.to_xml(), dict.fromkeys(hinges, self._servo))

    def urdf(self) -> str:
        """Return the body of a plan as URDF; '' for bodies that evolve."""
        from gaitsim_robot.urdf import urdf

        if self.body == EVOLVE:
            return ""
        simulation = self.model_copy(update={"world": {}}).simulation
        return urdf(simulation.model, simulation.anatomy, simulation.servos)

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return displacement, speed and effort, and what the bodies are like."""
        if self.body != EVOLVE:
            bodies, rows = self._plan, np.zeros(motion.population, np.intp)
        else:
            bodies = self._tree_space.grow(motion["tree"])
            rows = np.arange(motion.population)
        return creature_measures(motion, bodies, rows)

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions: ground, masses, servos, initial pose and pushes."""
        return robot_conditions(self.friction, self._servo.latency)

    def checks(self) -> Sequence[Mapping[str, float]]:
        """Return worlds with softer contacts, other friction, later, softer and stiffer servos."""
        return robot_checks(self._servo.latency)

    def physics_engine(self) -> str:
        """Return 'mujoco', or the library of another engine."""
        return self.engine if self.engine == MUJOCO else str(physics(self.engine).LIBRARY)

    def design(self) -> str:
        """Return the plan of the body; '' for bodies that evolve."""
        if self.body == EVOLVE:
            return ""
        return plan_text(self._plan.modules[0, : self._plan.counts[0]])

    def describe(self) -> Facts:
        """Describe the modules, and the body of a plan with its parts."""
        table = load_modules(self.modules)
        facts: dict[str, Mapping[str, str]] = {
            "Modules": {
                "source": table.source,
                "core": f"{1000 * max(table.core.size):.3g} mm, {1000 * table.core.mass:.3g} g",
                "brick": f"{1000 * max(table.brick.size):.3g} mm, {1000 * table.brick.mass:.3g} g",
                "hinge": f"±{table.hinge.reach:g}°, {self._servo.stall_torque:.3g} N m, "
                f"{self._servo.no_load_speed:.3g} rad/s",
            }
        }
        if self.body != EVOLVE:
            simulation = self.simulation
            facts["Body"] = {
                **describe_bodies(self._plan),
                "mass": f"{simulation.anatomy.mass:.3g} kg",
                "length": f"{simulation.anatomy.length:.3g} m",
                "plan": self.design(),
            }
        return facts

    @classmethod
    def library(cls) -> Facts:
        """Describe the published bodies."""
        found = {}
        for name in published():
            body = cls(body=name)
            mass = body.simulation.anatomy.mass
            parts = describe_bodies(body._plan)["parts"]
            found[name] = f"{parts}, {mass:.3g} kg"
        return {"Published bodies: organism.body": found}


@lru_cache(maxsize=64)  # the names of joints are asked for often
def _planned(body: str, modules: str) -> Bodies:
    """Return the body of a plan, a population of one, which must not be changed."""
    return grow_plan(parse_plan(body), load_modules(modules).shapes)


def _hinges(bodies: Bodies) -> tuple[str, ...]:
    """Return the places of the hinges of the first body."""
    modules = bodies.modules[0, : bodies.counts[0]]
    names = zip(place_names(modules), modules[:, 0].tolist(), strict=True)
    return tuple(name for name, kind in names if kind == HINGE)


def _oscillators(genome: Floats, bodies: Bodies, row: int) -> Floats:
    """Return amplitude, phase and offset of a body's hinges, (hinges, 3) rad."""
    modules = bodies.modules[row, : bodies.counts[row]]
    hinges = modules[modules[:, 0] == HINGE]
    nodes = genome[HEAD:].reshape(-1, WIDTH)[hinges[:, 4]]
    found: Floats = nodes[:, [AMPLITUDE, PHASE, OFFSET]]
    if genome[SYMMETRY] == ANTIPHASE:
        later = hinges[:, 5] == 1
        found[later, 1] = np.mod(found[later, 1] + math.pi, TWO_PI)
    return found


def _lie(simulation: Simulation, commands: Floats) -> Any:
    """Return the record of bodies without hinges, which lie still."""
    from gaitsim_robot.rollout import empty_record

    record = empty_record(simulation, *commands.shape[:2])
    record.qpos[:] = simulation.starts[:, None, 1 : 1 + simulation.model.nq]
    record.failures.update(dict.fromkeys(range(len(commands)), NO_HINGES))
    return record


@lru_cache(maxsize=128)  # elites keep their bodies; more would fragment the memory
def _load_simulation(
    modules: bytes,
    places: bytes,
    turns: bytes,
    halves: bytes,
    table: str,
    servo: Servo,
    options: tuple[tuple[str, float], ...],
    world: tuple[tuple[str, float], ...],
    seconds: float,
) -> Simulation:
    """Return a body in a world, given the bytes of its arrays in `Bodies`."""
    conditions = dict(world)
    lattice = lattice_for(conditions, seconds)
    found = build_creature(
        np.frombuffer(modules, np.int64).reshape(-1, 6),
        np.frombuffer(places).reshape(-1, 3),
        np.frombuffer(turns).reshape(-1, 3, 3),
        np.frombuffer(halves).reshape(-1, 3),
        load_modules(table),
        servo,
        MappingProxyType(dict(options)),
        lattice,
    )
    return apply_world(found, conditions) if world else found
