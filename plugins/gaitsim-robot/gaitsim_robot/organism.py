"""The body `robot`: any legged robot from a URDF or MJCF file."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from gaitsim.plugin import (
    COMMAND,
    DIMENSIONS_HELP,
    RANGES_HELP,
    WORLD_HELP,
    Array,
    BodyFile,
    Channel,
    Command,
    Condition,
    Controller,
    Dimension,
    Facts,
    FittedGait,
    GaitsimError,
    Genomes,
    Measure,
    Motion,
    Organism,
    Question,
    RealSpace,
    Reflex,
    Rhythm,
    Rig,
    Skeleton,
    Steered,
    check_dimensions,
    check_world,
    dimension_measures,
    folder_of,
    load_engine,
    load_reflexes,
    option,
    roots_of,
    unknown,
)
from gaitsim.plugin.toolkit import (
    DAMAGE_HELP,
    STRIDE_FREQUENCY,
    STRIDE_FREQUENCY_CHANNEL,
    Damage,
    GeneGroup,
    Servo,
    angles_frequency,
    check_joint_angles,
    check_sensors,
    check_time_step,
    dimension_genes,
    genome_space,
    parse_damage,
)
from gaitsim_robot.anatomy import Anatomy, Facing
from gaitsim_robot.chain import pose_data, sliding
from gaitsim_robot.conditions import robot_checks, robot_conditions
from gaitsim_robot.designs import DesignedRobot, DesignSpace, Factors
from gaitsim_robot.drives import (
    CALIBRATION_TIME,
    Pushes,
    check_drive,
    clipped_commands,
    pushes,
    targets,
    true_shares,
)
from gaitsim_robot.encodings import Encoding, Kind, Symmetry
from gaitsim_robot.feeling import (
    NO_REFLEXES,
    Pilot,
    ReflexGenes,
    check_evolve,
    check_needs,
    select_options,
    started,
)
from gaitsim_robot.loading import (
    BUNDLED,
    ServoOptions,
    bundled_text,
    describe_library,
    describe_robot,
    imported_file,
    joint_ranges,
    load_anatomy,
    load_designs,
    load_encoding,
    load_servos,
    load_simulation,
    robot_text,
    servo_latency,
)
from gaitsim_robot.measures import measures
from gaitsim_robot.questions import ask
from gaitsim_robot.servos import ServoName
from gaitsim_robot.simulation import FRAME_RATE, Simulation
from gaitsim_robot.text import compile_model, trust, with_motors, with_servos
from gaitsim_robot.units import unit_warning

XYZ = ("x", "y", "z")
FASTEST = 5.0  # Hz
Share = Annotated[float, Field(ge=0.05, le=20)]
HORNS = 2.0  # °, standard deviation of the errors with which servo horns are mounted

CHANNELS: Mapping[str, Channel] = {
    "joint_angles": Channel(
        ("frames", "joints"),
        "rad",
        "commands to the servos, relative to the file's zero; m of slides",
    ),
    "joint_positions": Channel(("frames", "joints"), "rad", "actual angles; m of slides"),
    "joint_velocities": Channel(("frames", "joints"), "rad/s", "velocities; m/s of slides"),
    "torque": Channel(
        ("frames", "joints"),
        "N m",
        "mean magnitude of the torque since the previous frame; N of slides, as in the next three",
    ),
    "stall_torque": Channel(("joints",), "N m", "largest torque of the servos; 0 if unknown"),
    "rms_torque": Channel(
        ("joints",), "N m", "root mean square of the torque in each physics step, until the fall"
    ),
    "continuous_torque": Channel(
        ("joints",), "N m", "torque of the servos without overheating; 0 if unknown"
    ),
    "torso": Channel(
        ("frames", XYZ), "m", "origin of the trunk, relative to the ground below its start"
    ),
    "torso_velocity": Channel(("frames", XYZ), "m/s", "velocity of the trunk's origin"),
    "orientation": Channel(
        ("frames", ("roll", "pitch", "yaw")),
        "rad",
        "roll to the right, pitch nose down, yaw to the left",
    ),
    "height": Channel(("frames",), "m", "height of the trunk's origin above the ground"),
    "foot_positions": Channel(
        ("frames", "feet", XYZ), "m", "points of the feet that touch the ground when standing"
    ),
    "stance": Channel(
        ("frames", "feet"), "", "whether the foot carried load since the previous frame"
    ),
    "load": Channel(
        ("frames", "feet", XYZ),
        "N",
        "mean force of the ground on each foot since the previous frame",
    ),
    "slip": Channel(("frames",), "m", "mean slide of the stance feet since the previous frame"),
    "energy": Channel(
        ("frames",), "J", "work of the servos since the start; braking counts as positive"
    ),
    STRIDE_FREQUENCY: STRIDE_FREQUENCY_CHANNEL,
    "lasted": Channel((), "s", "time until the fall, or the length of the rollout"),
    "weight": Channel((), "N", "weight of the whole robot"),
    "length": Channel((), "m", "length of the trunk; with two legs, at least that of a leg"),
    "configuration": Channel(
        ("frames", "coordinates"),
        "",
        "position and quaternion of the trunk, then the angles of all joints, m and rad",
    ),
}


FELT: Mapping[str, Channel] = {
    "command": Channel(
        ("frames", COMMAND),
        ("m/s", "rad/s", "m/s", "m"),
        "commands of the driver, smoothed: forward, to the left, to the left, upward",
    ),
    "changed_command": Channel(
        ("frames", COMMAND),
        ("m/s", "rad/s", "m/s", "m"),
        "commands with the changes of reflexes",
    ),
    "measured_orientation": Channel(
        ("frames", ("roll", "pitch", "yaw")), "rad", "orientation as the IMU measures it"
    ),
    "commanded_heading": Channel(
        ("frames",), "rad", "direction that the commands ask for, to the left of the start"
    ),
}
"""The channels of a robot that feels or is driven, besides `CHANNELS`."""


EVOLVED: Mapping[str, Channel] = {
    "dimensions": Channel(("dimensions",), "", "factors of the dimensions that evolve")
}
"""The channel of a robot whose dimensions evolve, besides the others."""


class _Channels:
    """The channels of a robot; the class itself shows all that robots may have."""

    def __get__(self, robot: "Robot | None", owner: type) -> Mapping[str, Channel]:
        found = CHANNELS if robot is not None and not robot.feels else {**CHANNELS, **FELT}
        evolves = robot is None or robot._evolving[0]
        return {**found, **EVOLVED} if evolves else found


MUJOCO = "mujoco"
"""The engine of robots; packages add others."""


def physics(engine: str) -> Any:
    """Return the module of an engine, with `roll_out` and `feel_out` as in `gaitsim_robot.rollout`.

    Raises:
        GaitsimError: the engine is not installed.
    """
    if engine == MUJOCO:
        from gaitsim_robot import rollout

        return rollout
    return load_engine(engine, MUJOCO)


class Robot(Organism):
    """Any legged robot from a URDF or MJCF file, in rigid-body physics."""

    model: str = option(
        "quadruped",
        "a bundled robot ('quadruped', 'hexapod' or 'spider-physics'), the path of a URDF or MJCF "
        "file, or the text into which gaitsim converts such a file",
    )
    scale: float = option(
        1.0,
        "factor for all lengths in the robot's file, such as 0.001 for millimetres; experiments "
        "and runs store the scaled robot, with a scale of 1",
        ge=1e-6,
        le=1e6,
    )
    mass_scale: float = option(
        1.0,
        "factor for all masses in the robot's file, such as 0.001 for grams; experiments and runs "
        "store the scaled robot, with a factor of 1",
        ge=1e-6,
        le=1e6,
    )
    encoding: Kind = option(
        "steps",
        "rule that turns a genome into joint angles: 'steps' moves the feet in step cycles by "
        "inverse kinematics, 'sine' gives each joint a sine wave, 'cpg' uses coupled oscillators "
        "that start from the standing pose",
    )
    symmetry: Symmetry = option(
        "none",
        "symmetry of the gait: with 'alternating' and 'trot', each leg takes turns with "
        "its neighbours and with the opposite leg; with 'bound', front and back legs "
        "take turns; with 'wave', steps run from back to front",
    )
    fastest_stride: float = option(
        2.5,
        "upper bound of the frequency gene, in strides per second",
        unit="Hz",
        gt=0.5,
        le=FASTEST,
    )
    heading: float = option(
        0.0,
        "direction of the strides with encoding 'steps': 0 is forward, 90 is to the left",
        unit="°",
        ge=-180,
        le=180,
    )
    duration: float = option(10.0, "length of a rollout", unit="s", ge=0.5, le=600)
    feet: tuple[str, ...] = option(
        (), "names of the links at the ends of the legs; by default, gaitsim finds the legs"
    )
    motors: tuple[str, ...] = option(
        (),
        "names of the joints with motors, or 'all'; others are passive, with their springs and "
        "damping; by default, those that the actuators or transmissions in the robot's file drive, "
        "or all if it states none; a joint without limits turns by ±90°",
    )
    swing: tuple[str, ...] = option(
        (),
        "names of joints outside the legs, such as of a spine or tail, that swing with the rhythm; "
        "amplitude and phase of each are genes; by default, all hold the standing pose",
    )
    wheels: Literal["hold", "roll", "both"] = option(
        "hold",
        "what wheels at the ends of legs do: 'hold' keeps them still while the legs walk, 'roll' "
        "rolls them while the legs stand, 'both' walks and rolls; their speed is a gene",
    )
    facing: Facing = option(
        "auto",
        "direction of the nose in the robot's file, with z up; 'auto' follows the names of the "
        "legs, such as FL and front_left, if they fit only one direction, or else the shape of the "
        "robot",
    )
    stance: dict[str, float] = option(
        {},
        "joint angles in the standing pose, by name, and metres of joints that slide; other joints "
        "have the angles of the file's keyframe, or zero; by default, gaitsim finds a pose",
        unit="°",
    )
    dt: float = option(
        0.004,
        "time step of the physics; 1/50 s must be a whole multiple of it",
        unit="s",
        ge=2e-4,
        le=0.01,
    )
    servo: ServoName = option(
        "model",
        "servo of each joint: 'model' uses the limits in the robot's file, 'ideal' has almost no "
        "limits, and the others are hobby servos with values from their data sheets",
    )
    torque_limit: float | None = option(
        None, "largest torque of a servo; by default, the servo's own", unit="N m", gt=0, le=1e5
    )
    speed_limit: float | None = option(
        None, "no-load speed of a servo; by default, the servo's own", unit="rad/s", gt=0, le=100
    )
    latency: float | None = option(
        None,
        "delay from a command to the servo's torque; by default, the servo's own",
        unit="s",
        ge=0,
        le=0.2,
    )
    stiffness: float | None = option(
        None,
        "torque of a servo per radian of position error; by default, the servo's own",
        unit="N m/rad",
        gt=0,
        le=1e6,
    )
    engine: str = option(
        MUJOCO, "physics engine: 'mujoco', or 'bullet' (PyBullet) with the package gaitsim-bullet"
    )
    friction: float = option(0.8, "coefficient of friction between feet and ground", ge=0, le=5)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)
    damage: tuple[str, ...] = option((), DAMAGE_HELP)
    world: dict[str, float] = option({}, WORLD_HELP)
    horns: dict[str, Annotated[float, Field(ge=-45, le=45)]] = option(
        {},
        "constant errors of joints relative to their commands, by name, such as of servo horns; "
        "'gaitsim robots identify' finds them",
        unit="°",
    )
    reflexes: dict[str, dict[str, Any]] = option(
        {},
        "reflexes that change the gait by the measurements of sensors, in this order",
        allowed="by name, tables of options that differ from the reflex's defaults, such as "
        "{ heading = { gain = 2.0 } }",
    )
    dimensions: dict[str, float] = option({}, DIMENSIONS_HELP)
    evolve: tuple[str, ...] = option(
        (),
        "dimensions that are genes, and options of reflexes that are genes within their bounds",
        allowed="a list of names such as 'shank' or 'heading.gain'",
    )
    ranges: dict[str, tuple[float, float]] = option({}, RANGES_HELP)
    growth: float = option(
        0.5,
        "share of a link's mass that grows with its length; the rest, such as servos and feet, "
        "keeps its mass",
        ge=0,
        le=1,
    )
    sensors: tuple[str, ...] = option(
        ("mpu6050",),
        "sensors of the robot, whose measurements reflexes use",
        allowed="a list with one of the IMUs mpu6050, bno055 and ideal; contacts or load of the "
        "feet; joints, for servos that report their angles",
    )
    drive: tuple[dict[str, float], ...] = option(
        (),
        "commands over time; parts that an entry does not name keep their values; without a drive, "
        "the gait walks as it evolved",
        allowed="a list of tables such as { at = 2.0, speed = 0.2, turn = 30.0 }: at in s; speed, "
        "and sideways to the left, in m/s; turn to the left in °/s; height in m; push in m/s, with "
        "its direction in °",
    )
    command_gains: tuple[Share, Share, Share] = option(
        (1.0, 1.0, 1.0),
        "true speed, turn and sideways speed as shares of those of strokes without slip; strokes "
        "for a command are divided by them; 'gaitsim steer' measures them",
        allowed="three numbers from 0.05 to 20",
    )

    dynamic: ClassVar[bool] = True
    channels: ClassVar[Any] = _Channels()
    _fleet: "tuple[Encoding, Simulation] | None" = PrivateAttr(None)

    @model_validator(mode="after")
    def _import_model(self, info: ValidationInfo) -> Self:
        """Replace the path of a file by the scaled robot's text, which needs no scale; check it."""
        check_time_step(self.dt, FRAME_RATE)
        _ = self._physics
        folder, roots = folder_of(info, "model"), roots_of(info)
        scales = {"scale": self.scale, "mass_scale": self.mass_scale}
        try:
            text = robot_text(self.model, folder, roots, **scales)
            for name, value in (("model", text), ("scale", 1.0), ("mass_scale", 1.0)):
                object.__setattr__(self, name, value)  # the model is frozen
            _ = self._original
        except GaitsimError as error:
            error.key = error.key or "model"
            raise
        self._check_dimensions()
        _ = self._damage
        reflexes = load_reflexes(self.reflexes)
        given = {name: reflex.model_dump(mode="json") for name, reflex in reflexes.items()}
        object.__setattr__(self, "reflexes", given)
        check_sensors(self.sensors)
        check_needs(reflexes, self.sensors)
        space = self.design_space() if self.evolve else ()
        check_evolve(self._evolving[1], reflexes, [*space])
        check_drive(self.drive)
        check_world(self.world, self.conditions())
        turning = [name for name in self.anatomy.joints if name not in self.sliding_joints()]
        for name in self.horns:
            if name not in turning:
                raise unknown("joint", name, turning, key="horns")
        return self

    def _check_dimensions(self) -> None:
        """Check the options of dimensions, and that the design can stand."""
        if not (self.dimensions or self.evolve or self.ranges):
            return
        designs, evolving = self._designs, self._evolving[0]
        for name in (*self.dimensions, *self.evolve):
            if name not in designs.dimensions and (reason := designs.missing(name)):
                allowed = ", ".join(designs.dimensions)
                raise GaitsimError(reason, key="dimensions", allowed=allowed)
        check_dimensions(designs.dimensions, self.dimensions, evolving, self.ranges)
        if self.dimensions and (problem := self._design.problem):
            raise GaitsimError(
                f"the robot with these dimensions does not stand: {problem}",
                key="dimensions",
                allowed="factors closer to 1",
            )

    @property
    def threads(self) -> bool:  # type: ignore[override]
        """Whether the engine releases the interpreter's lock; PyBullet does not."""
        return self.engine == "mujoco"

    @property
    def text(self) -> str:
        """Text of the robot with its dimensions, an MJCF document."""
        if self.dimensions:
            trust(self._design.text)  # it follows from a text that was checked
        return self._text

    @property
    def _text(self) -> str:
        return self._design.text if self.dimensions else self._original_text

    @property
    def _original_text(self) -> str:
        text = bundled_text(self.model) if self.model in BUNDLED else self.model
        return with_motors(text, self.motors) if self.motors else text

    @property
    def frames(self) -> int:
        """Number of frames of a rollout, including the start."""
        return round(self.duration * FRAME_RATE) + 1

    @property
    def anatomy(self) -> Anatomy:
        """Legs, feet and standing pose of the intact robot."""
        return self._design.anatomy if self.dimensions else self._original

    @property
    def _original(self) -> Anatomy:
        """The anatomy of the robot without changed dimensions."""
        stance = tuple(self.stance.items())
        rolls = self.wheels != "hold"
        text = self._original_text
        return load_anatomy(text, self.feet, stance, self.facing, self.swing, rolls)

    @property
    def _designs(self) -> DesignSpace:
        """The dimensions of the robot, and its designs."""
        return load_designs(self._original_text, self._original, self._servo, self.growth)

    @property
    def _factors(self) -> Factors:
        return tuple(sorted(self.dimensions.items()))

    @property
    def _design(self) -> DesignedRobot:
        return self._designs.designs([self._factors])[0]

    @property
    def _servos(self) -> dict[str, Servo]:
        """The servo of each driven joint, by name, with the limits of the original."""
        factor = self.dimensions.get("servos", 1.0)
        return load_servos(self._original_text, self._original, self._servo, factor)

    @property
    def _evolving(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The dimensions that are genes, and the options of reflexes that are genes."""
        space = self.design_space() if self.evolve else {}
        dimensions = tuple(name for name in self.evolve if name in space)
        return dimensions, tuple(name for name in self.evolve if name not in space)

    def design_space(self) -> Mapping[str, Dimension]:
        """Return the dimensions: lengths of segments, positions of hips, and servos."""
        return self._designs.dimensions

    @property
    def simulation(self) -> Simulation:
        """The robot with its damage in its world; cached after the first compilation."""
        if self._fleet:
            return self._fleet[1]
        return self._simulation(self._damage, self.world, self.horns)

    def _population(self, bodies: Sequence[tuple[Encoding, Simulation]]) -> Self:
        """Return this robot with a body of its own for each individual of a population."""
        encodings, simulations = zip(*bodies, strict=True)
        found = self.model_copy()
        encoding = replace(self._encoding, bodies=encodings)
        found._fleet = encoding, self.simulation.of_bodies(simulations)
        return found

    def _simulation(
        self,
        damage: tuple[Damage, ...],
        world: Mapping[str, float],
        horns: Mapping[str, float] = MappingProxyType({}),
    ) -> Simulation:
        errors = [math.radians(horns.get(name, 0.0)) for name in self.anatomy.joints]
        return load_simulation(
            (
                self._text,
                self.anatomy,
                tuple(self._servos.items()),
                self.dt,
                self.friction,
                self.gravity,
                damage,
            ),
            tuple(sorted(world.items())),
            math.inf if self.drive else self.duration,  # the same ground for any length of a drive
            tuple(errors) if any(errors) else (),
        )

    @property
    def _damage(self) -> tuple[Damage, ...]:
        if not self.damage:
            return ()
        ranges = joint_ranges(self._original_text, self._original)
        limits = dict(zip(self.anatomy.joints, ranges, strict=True))
        slides = dict.fromkeys(self.sliding_joints(), (-math.inf, math.inf))
        found = parse_damage(self.damage, self.leg_joints(), limits=limits | slides)
        for one in found:
            if one.kind == "stuck" and one.value is not None and one.part in slides:
                what = f"the joint {one.part!r} slides, so it cannot stick at an angle"
                raise GaitsimError(what, key="damage")
        return found

    @property
    def _servo(self) -> ServoOptions:
        return self.servo, self.torque_limit, self.speed_limit, self.latency, self.stiffness

    def describe(self) -> Facts:
        """Describe mass, legs, servos, standing pose, damage and world."""
        units = {name: condition.unit for name, condition in self.conditions().items()}
        world = {
            name: f"{value:g} {units.get(name, '')}".rstrip() for name, value in self.world.items()
        }
        simulation = self.simulation
        if push := self.world.get("push"):
            world["push"] += f" = {push * simulation.anatomy.mass:.3g} N s"
        shown = {
            name: _dimension(one, self.dimensions.get(name, 1.0))
            for name, one in self.design_space().items()
            if "." not in name or name.startswith("hips") or name in self.dimensions
        }
        facts = dict(describe_robot(simulation, self._servos, world))
        return {**facts, "Dimensions: organism.dimensions": shown} if shown else facts

    def warnings(self) -> tuple[str, ...]:
        """Return likely mistakes in the robot's file."""
        anatomy, found = self.anatomy, self.imported()
        of_file = found.warnings if found else ()
        units = unit_warning(anatomy.length, anatomy.mass)
        return tuple(filter(None, (units, *of_file, *anatomy.warnings)))

    def questions(self) -> tuple[Question, ...]:
        """Return what was guessed about the robot's file; () for a bundled robot."""
        if self.model in BUNDLED:
            return ()
        return ask(compile_model(self.text), self.anatomy, self._servos)

    def gait_warnings(self, genome: Genomes) -> tuple[str, ...]:
        """Return a warning about commands of the drive beyond what a gait can do."""
        if not self.drive:
            return ()
        found = clipped_commands(self.drive, self._gaits(genome[None])[0])
        return (found,) if found else ()

    @classmethod
    def library(cls) -> Facts:
        """Describe the bundled robots and servos."""
        return describe_library({name: cls(model=name).anatomy for name in BUNDLED})

    def imported(self) -> BodyFile | None:
        """Return the file from which this process read the robot; None for other robots."""
        return imported_file(self.model)

    def genome_space(self) -> RealSpace:
        """Return the genome space of the encoding, and of the reflexes."""
        groups = (*self._encoding.groups, *self._reflex_genes.groups, *self._dimension_genes)
        return genome_space(groups)

    def starts(self) -> Mapping[str, Array]:
        """Return gaits made by hand that suit the legs, such as a trot."""
        genes = self._dimension_genes
        factors = [np.clip(1.0, group.lower, group.upper) for group in genes]
        own = np.concatenate([self._reflex_genes.start, *factors])
        return {
            name: np.concatenate([start, own]) for name, start in self._encoding.starts().items()
        }

    @property
    def _dimension_genes(self) -> tuple[GeneGroup, ...]:
        """The genes of the dimensions that evolve, factors, the last ones of a genome."""
        names = self._evolving[0]
        return dimension_genes(self.design_space(), names, self.ranges) if names else ()

    @property
    def feels(self) -> bool:
        """Whether reflexes or a driver change the gait while it runs."""
        return bool(self.reflexes or self.drive)

    @property
    def _reflex_genes(self) -> ReflexGenes:
        """The reflexes with the genes of their options and weights."""
        if not self.reflexes:
            return NO_REFLEXES
        return ReflexGenes(load_reflexes(self.reflexes), self._evolving[1], self._encoding.legs)

    @property
    def _encoding(self) -> Encoding:
        # The intact robot in its nominal world, as damage and worlds do not change the meaning of
        # a genome.
        if self._fleet:
            return self._fleet[0]
        heading = math.radians(self.heading)
        return load_encoding(
            self._simulation((), {}),
            self.encoding,
            self.symmetry,
            self.fastest_stride,
            heading,
            self.wheels != "roll",
        )

    def move(self, genomes: Genomes) -> Motion:
        """Simulate the walk of each individual separately."""
        if self._evolving[0]:
            return self._move_designs(genomes)
        if self.feels:
            return self._feel(genomes)
        return self._walk(*self._encoding.commands(genomes, self.frames))

    def _move_designs(self, genomes: Genomes) -> Motion:
        """Simulate individuals that have their own dimensions."""
        names = self._evolving[0]
        bodies = [self.embody(genome)[0] for genome in genomes]
        self._designs.designs([body._factors for body in bodies])  # all at once
        bare = self.model_copy(update={"evolve": self._evolving[1], "ranges": {}})
        standing, failures, pairs = bare.simulation.stands, {}, []
        for index, body in enumerate(bodies):
            problem = body._design.problem
            # In this order, the simulation of the intact robot is compiled once: caches are small.
            pair = (bare if problem else body)._encoding, (bare if problem else body).simulation
            if standing and not pair[1].stands:
                problem = "it falls while it stands"
                pair = bare._encoding, bare.simulation
            if problem:
                failures[index] = f"the robot with these dimensions does not stand: {problem}"
                bodies[index] = bare
            pairs.append(pair)
        genes = genomes[:, : -len(names)]
        if self.engine == MUJOCO:
            moved = bare._population(pairs).move(genes)
        else:  # other engines simulate individuals one after another, in any case
            single = [body.move(gene[None]) for body, gene in zip(bodies, genes, strict=True)]
            joined = {name: np.concatenate([one[name] for one in single]) for name in single[0]}
            reasons = {index: one.failures[0] for index, one in enumerate(single) if one.failures}
            moved = Motion(FRAME_RATE, joined, failures=reasons)
        moved.failures.update(failures)
        moved.add("dimensions", genomes[:, -len(names) :].copy())
        return moved

    def _feel(self, genomes: Genomes) -> Motion:
        """Simulate robots whose gaits follow reflexes and commands."""
        pilot = self.pilot(genomes)
        target = np.zeros((len(genomes), self.frames, len(COMMAND)))
        if self.drive:
            target[:] = targets(self.drive, self.frames, FRAME_RATE)
        else:
            target[..., 0] = pilot.rhythm.own_speed[:, None]
        return self._driven(pilot, target, pushes(self.drive, FRAME_RATE))

    def _driven(self, pilot: Pilot, target: Array, pushed: Pushes) -> Motion:
        """Simulate robots with commands in each frame, (population, frames, 4), and pushes."""
        from gaitsim_robot import rollout

        frequency = pilot.rhythm.frequency
        record, feelings = self._physics.feel_out(self.simulation, pilot, target, pushed)
        return rollout.motion_of(self.simulation, record, feelings.angles, frequency, feelings)

    def pilot(self, genomes: Genomes) -> Pilot:
        """Return the controllers of a population, standing at the start."""
        gaits = self._gaits(genomes)
        return Pilot(*gaits, self.sensors, self.world, self.frames, 1 / FRAME_RATE)

    def _gaits(self, genomes: Genomes) -> tuple[Rhythm, dict[str, Reflex], dict[str, Array]]:
        """Return the rhythms of a population, its reflexes, and their weights, by name."""
        encoding = self._encoding
        reflexes, weights = self._reflex_genes.decode(genomes[:, encoding.genes :])
        rhythm = encoding.rhythm(genomes[:, : encoding.genes])
        rhythm.gains[:] = self.command_gains
        return rhythm, reflexes, weights

    def reflex_names(self) -> tuple[str, ...]:
        """Return the names of the reflexes."""
        return tuple(self.reflexes)

    def controller(self, genome: Genomes) -> Controller:
        """Return a gait as a rhythm with its reflexes, with commands as the simulation walks."""
        rhythm, evolved, weights = self.calibrated(genome)._gaits(genome[None])
        reflexes = {name: select_options(reflex, 0) for name, reflex in evolved.items()}
        states = {
            name: started(name, one, rhythm.legs, weights[name]) for name, one in reflexes.items()
        }
        return Controller(rhythm, reflexes, states, 1 / FRAME_RATE)

    def fit_gait(
        self, joint_angles: Array, frequency: float, frame_rate: float, *, steered: bool = True
    ) -> FittedGait:
        """Return a gait of sines; a steered one has a reflex, `heading` by default."""
        options = {
            "encoding": "sine",
            "symmetry": "none",
            "fastest_stride": min(max(self.fastest_stride, frequency), FASTEST),
            "reflexes": self.reflexes or ({"heading": {}} if steered else {}),
        }
        robot = self.model_copy(update=options)
        genome, angles = robot._encoding.fit(joint_angles, frequency, frame_rate)
        genome = np.concatenate([genome, robot._reflex_genes.start])
        return FittedGait(options, genome, angles)

    def blind(self, genomes: Genomes) -> tuple[Organism, Genomes] | None:
        """Return the robot without reflexes; a drive still moves it."""
        if not self.reflexes:
            return None
        names = self._evolving[0]
        plain = self.model_copy(update={"reflexes": {}, "evolve": names})
        genes = np.split(genomes, [self._encoding.genes, genomes.shape[1] - len(names)], axis=1)
        return plain, np.concatenate([genes[0], genes[2]], axis=1)

    def calibrated(self, genome: Genomes) -> Self:
        """Return the robot with the `command_gains` of a gait, measured in its nominal world."""
        nominal: dict[str, Any] = {"drive": (), "reflexes": {}, "world": {}, "horns": {}}
        plain = self.model_copy(update={**nominal, "duration": CALIBRATION_TIME})
        genes = genome[: self._encoding.genes]
        rhythm = self._encoding.rhythm(genes[None])
        tests = np.diag(rhythm.limits[0, :3] * [0.8, 0.5, 0.5])
        tests[0, 0] = rhythm.own_speed[0]
        target = np.zeros((3, plain.frames, len(COMMAND)))
        target[..., :3] = tests[:, None]
        motion = plain._driven(plain.pilot(np.tile(genes, (3, 1))), target, {})
        return self.model_copy(update={"command_gains": true_shares(motion, tests)})

    def play(self, joint_angles: Array) -> Motion:
        """Walk with the given servo commands, clipped to the limits of the joints.

        Args:
            joint_angles: commands relative to the file's zero, (population, frames, joints) rad,
                at 50 frames per second; at least 2 frames, the first of which is the initial pose.
        """
        check_joint_angles(joint_angles, len(self.anatomy.joints))
        lower, upper = np.array(joint_ranges(self._original_text, self._original)).T
        angles = np.clip(joint_angles.astype(np.float64), lower, upper)
        motion = self._walk(angles, angles_frequency(angles, FRAME_RATE))
        if names := self._evolving[0]:
            motion.add("dimensions", np.ones((len(angles), len(names))))
        return motion

    def physics_engine(self) -> str:
        """Return 'mujoco', or the library of another engine."""
        return self.engine if self.engine == MUJOCO else str(self._physics.LIBRARY)

    @property
    def _physics(self) -> Any:
        """The module of the engine.

        Raises:
            GaitsimError: the engine is not installed.
        """
        return physics(self.engine)

    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the leg joints as in the file, leg by leg."""
        return self.anatomy.joints

    def sliding_joints(self) -> tuple[str, ...]:
        """Return the leg joints that slide, whose angles are in metres."""
        model = compile_model(self.text)
        return tuple(name for name in self.anatomy.joints if sliding(model)[model.joint(name).id])

    def passive_places(self) -> Array:
        """Return the places of joints without motors in the standing pose, (joints, 3) m."""
        model, start = self.simulation.model, self.simulation.start
        joints = [model.joint(name).id for name in self.anatomy.passive]
        places = pose_data(model, start[1 : 1 + model.nq]).xanchor[joints]
        return np.asarray(places - [*start[1:3], 0.0])

    def standing_pose(self) -> Array:
        """Return the joint angles of the intact robot in its standing pose, (joints,) rad."""
        model, anatomy = compile_model(self.text), self.anatomy
        return anatomy.stance[[model.joint(name).qposadr[0] for name in anatomy.joints]]

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return the joints of each leg by its name: L1, R1 …, or M1 … in the middle."""
        return {leg.name: leg.joints for leg in self.anatomy.legs}

    def commands(self) -> tuple[Command, ...]:
        """Return the commands of a driver: to stop, walk, turn, and be pushed."""
        from gaitsim_robot.steering import COMMANDS

        return COMMANDS

    def controller_names(self) -> tuple[str, ...]:
        """Return the only controller: a gait, which any individual is."""
        return ("gait",)

    def controllers(self) -> Mapping[str, Genomes]:
        """Return the first gait made by hand."""
        return {"gait": next(iter(self.starts().values()))}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return the standing robot, which obeys a driver; its command gains are measured."""
        from gaitsim_robot.steering import LONGEST, STANDING, SteeredRobot

        if self.engine != "mujoco":
            raise GaitsimError(
                "robots are steered in MuJoCo only",
                key="organism.engine",
                allowed="mujoco",
                remedy="steer with --set organism.engine=mujoco; the recorded drive can be played "
                "in another engine with --engine",
            )
        genome, genes = controllers["gait"], self.genome_space().genes
        if np.shape(genome) != (genes,):
            raise GaitsimError(f"the gait has shape {np.shape(genome)}, expected ({genes},)")
        body, genome = self.embody(genome)
        own = body.calibrated(genome)
        # The moment of the world's own push would depend on the length of the drive.
        world = {name: value for name, value in self.world.items() if name != "push"}
        changes = {"drive": (STANDING,), "duration": LONGEST, "world": world}
        driven = own.model_copy(update=changes)
        framed = {name for name, one in driven.channels.items() if one.axes[:1] == ("frames",)}
        options = {"command_gains": [*own.command_gains], "world": world}
        return SteeredRobot(driven.simulation, driven.pilot(genome[None]), framed, options)

    def _walk(self, angles: Array, frequency: Array) -> Motion:
        from gaitsim_robot.rollout import walk

        return walk(self.simulation, angles, self._physics.roll_out, frequency)

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions: ground, masses, servos, initial pose and pushes."""
        return robot_conditions(self.friction, servo_latency(self._servo))

    def checks(self) -> Sequence[Mapping[str, float]]:
        """Return worlds with softer contacts, other friction, later, softer and stiffer servos.

        A robot with reflexes must also walk with errors of its servo horns, which turn every gait
        without reflexes off its course.
        """
        horns = ({"joint_offset": HORNS},) if self.reflexes else ()
        return (*robot_checks(servo_latency(self._servo)), *horns)

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return displacement, speed, duration, effort, slip, steps and posture."""
        own = dimension_measures(self._evolving[0], motion)
        return {**measures(motion, self.anatomy.legs), **own}

    def rig(self) -> Rig | None:
        """Return the tree of bodies; None for one with mimic joints, closed linkages or slides."""
        from gaitsim_robot.skeleton import rig

        simulation = self.simulation
        return rig(simulation.model, simulation.anatomy, simulation.damage)

    def urdf(self) -> str:
        """Return the robot as URDF; '' for one with mimic joints, closed linkages or slides."""
        from gaitsim_robot.text import compile_model
        from gaitsim_robot.urdf import urdf

        return urdf(compile_model(self.text), self.anatomy, self._servos)

    def mjcf(self) -> str:
        """Return the robot as MJCF, with the limits and gains of its servos.

        The option `model` reads it as it is. A latency of the servos is not part of it.
        """
        return with_servos(self.text, self._servos)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the solids of the body, and the segments from joint to joint."""
        from gaitsim_robot.skeleton import skeleton

        if self._evolving[0] and "dimensions" in motion:
            return self.embody(motion["dimensions"][individual])[0].skeleton(motion, individual)
        return skeleton(self.simulation, motion, individual)


def _dimension(dimension: Dimension, factor: float) -> str:
    """Return the value of a dimension with its factor, in mm if it is a length."""
    scale, unit = (1000, "mm") if dimension.unit == "m" else (1, dimension.unit)
    value = f"{scale * factor * dimension.nominal:.3g} {unit}"
    return f"{value}, {dimension.help}" + (f"; × {factor:.3g}" if factor != 1 else "")
