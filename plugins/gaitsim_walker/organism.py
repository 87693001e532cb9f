"""The walker: a torso on two or four legs, seen from the side."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import model_validator

from gaitsim.plugin import (
    DIMENSIONS_HELP,
    EVOLVE_HELP,
    RANGES_HELP,
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Dimension,
    EvolvingChannels,
    Genomes,
    Measure,
    Motion,
    Organism,
    RealSpace,
    Rig,
    Skeleton,
    check_dimensions,
    check_world,
    dimension_measures,
    option,
)
from gaitsim.plugin.toolkit import (
    DAMAGE_HELP,
    STRIDE_FREQUENCY,
    STRIDE_FREQUENCY_CHANNEL,
    GeneGroup,
    Oscillators,
    angles_frequency,
    check_joint_angles,
    check_time_step,
    conditions,
    dimension_genes,
    draw_joint_errors,
    draw_push,
    genome_space,
    split_genomes,
    world_seed,
)
from gaitsim_walker.body import DIMENSIONS, FRAME_RATE, Floats, WalkerPlan, plan_of, rig
from gaitsim_walker.damage import Impairment, impairment_of
from gaitsim_walker.measures import measures, skeleton
from gaitsim_walker.surroundings import STEP, Surroundings, ground

SLOWEST = 0.5  # Hz, lower bound of the frequency gene
_DEGREE = math.pi / 180


def groups(plan: WalkerPlan, alternating: bool, fastest: float) -> tuple[GeneGroup, ...]:
    """Return the gene groups: six with one gene per leg, and the frequency.

    In an alternating gait, only the near legs have genes.
    """
    legs = tuple(leg.name for leg in plan.legs)
    by_leg: tuple[GeneGroup, ...] = (
        GeneGroup("swing", legs, 0.0, 35 * _DEGREE),
        GeneGroup("lean", legs, -15 * _DEGREE, 15 * _DEGREE),
        GeneGroup("bend", legs, 0.0, 40 * _DEGREE),
        GeneGroup("crouch", legs, -20 * _DEGREE, 20 * _DEGREE),
        GeneGroup("phase", legs, -math.pi, math.pi, periodic=True),
        GeneGroup("lag", legs, -math.pi, math.pi, periodic=True),
    )
    if alternating:
        by_leg = tuple(_near_legs(group) for group in by_leg)
    return (*by_leg, GeneGroup("frequency", ("",), SLOWEST, fastest))


def _near_legs(group: GeneGroup) -> GeneGroup:
    near = group.halved(math.pi if group.name == "phase" else 0.0)
    return replace(near, parts=tuple(leg.removeprefix("near").strip() for leg in near.parts))


def trot(plan: WalkerPlan, alternating: bool, fastest: float) -> Floats:
    """Return a trot made by hand, in which knees bend as legs swing forward: a genome (genes,)."""
    gaits: dict[str, ArrayLike] = {
        "swing": 15 * _DEGREE,
        "lean": 0.0,
        "bend": 10 * _DEGREE,
        "crouch": -10 * _DEGREE,
        "phase": _trot(len(plan.legs)),
        "lag": math.pi / 2,
        "frequency": 1.5,
    }
    genes = groups(plan, alternating, fastest)
    values = [np.resize(np.asarray(gaits[group.name]), len(group.parts)) for group in genes]
    return np.asarray(genome_space(genes).repair(np.concatenate(values)[None])[0])


def commands(
    plans: Sequence[WalkerPlan],
    genomes: Genomes,
    genes: tuple[GeneGroup, ...],
    encoding: str,
    frames: int,
) -> Floats:
    """Return the commands to the servos, (population, frames, joints) rad, within the limits.

    A leg swings about its hip by lean + swing · sin(2πft + φ), and its knee bends by crouch +
    bend · sin(2πft + φ + lag). The hip compensates for half of the knee's bend, or another share
    if thigh and shank differ, so that bending lifts the foot without moving it forward or back.

    `sine` moves at full amplitude from the start. `cpg` starts from a standing pose with the
    phases of a trot; its oscillators are coupled to a leading one.
    """
    plan = plans[0]  # the others differ in lengths alone
    swing, lean, bend, crouch, phase, lag, frequency = split_genomes(genomes, genes)
    oscillators = Oscillators(np.repeat(np.arange(len(plan.legs)), 2), frames, FRAME_RATE)
    amplitude, lags = _by_joint(swing, bend), _by_joint(np.zeros_like(lag), lag)
    if encoding == "cpg":
        angles = oscillators.cpg(
            amplitude,
            phase,
            lags,
            frequency[:, 0],
            start=_trot(len(plan.legs)),
            coupling="leader",
            strength=COUPLING,
        )
    else:
        angles = oscillators.sine(amplitude, phase, lags, frequency[:, 0])
    angles += _by_joint(lean, crouch)[:, :, None]
    knees = np.array([float(leg.knee) for leg in plan.legs])
    shares = np.array([one.compensation for one in plans])
    angles[:, 0::2] += knees[:, None] * angles[:, 1::2] * shares[:, None, None]
    return np.clip(angles.swapaxes(1, 2), -plan.limits, plan.limits)


COUPLING = 4.0  # 1/s, coupling to the leading oscillator


def _by_joint(hips: Floats, knees: Floats) -> Floats:
    """Interleave two arrays (population, legs) into (population, joints), hip before knee."""
    return np.stack([hips, knees], axis=2).reshape(len(hips), -1)


def _trot(legs: int) -> Floats:
    """Return the phases of a trot, or of two alternating legs, (legs,) rad."""
    return np.array([0.0, math.pi] if legs == 2 else [0.0, math.pi, math.pi, 0.0])


REACH = 5.0  # m/s; uneven ground is long enough for walkers of at most this speed
XYZ = ("x", "y", "z")
CHANNELS: Mapping[str, Channel] = {
    "joint_angles": Channel(
        ("frames", "joints"), "rad", "commands to the servos, relative to the stance at rest"
    ),
    "joint_positions": Channel(("frames", "joints"), "rad", "actual angles of the joints"),
    "torque": Channel(
        ("frames", "joints"), "N m", "magnitude of the mean torque since the previous frame"
    ),
    "stall_torque": Channel(("joints",), "N m", "largest torque of the servos"),
    "torso": Channel(("frames", XYZ), "m", "middle of the torso; y is 0, z is up"),
    "torso_velocity": Channel(("frames", XYZ), "m/s", "velocity of the torso's middle"),
    "pitch": Channel(("frames",), "rad", "pitch of the torso, positive nose up"),
    "orientation": Channel(
        ("frames", ("roll", "pitch", "yaw")),
        "rad",
        "roll to the right, pitch nose down, yaw to the left",
    ),
    "height": Channel(("frames",), "m", "height of the torso's middle above the ground"),
    "foot_positions": Channel(
        ("frames", "feet", XYZ), "m", "middles of the round feet in the world"
    ),
    "stance": Channel(("frames", "feet"), "", "whether the foot is on the ground"),
    "load": Channel(("frames", "feet", ("x", "z")), "N", "force of the ground on each foot"),
    "slip": Channel(("frames",), "m", "mean slide of the stance feet since the previous frame"),
    "energy": Channel(
        ("frames",), "J", "work of the servos since the start; braking counts as positive"
    ),
    STRIDE_FREQUENCY: STRIDE_FREQUENCY_CHANNEL,
    "lasted": Channel((), "s", "time until the fall, or the length of the rollout"),
    "weight": Channel((), "N", "weight of the whole body"),
    "length": Channel((), "m", "length of the torso"),
}


class Walker(Organism):
    """A torso on legs of thigh and shank in a vertical plane, in a rigid-body simulation."""

    legs: Literal[2, 4] = option(4, "number of legs: 4 under a level torso, 2 under an upright one")
    encoding: Literal["sine", "cpg"] = option(
        "sine",
        "rule that turns a genome into joint angles: 'sine' has its full amplitude from the start, "
        "'cpg' uses oscillators that start from the standing pose",
    )
    symmetry: Literal["none", "alternating"] = option(
        "none",
        "symmetry of the gait: with 'alternating', the far legs repeat the near legs' "
        "motion half a stride later, which about halves the number of genes",
    )
    fastest_stride: float = option(
        2.5, "upper bound of the frequency gene, in strides per second", unit="Hz", gt=0.5, le=5
    )
    duration: float = option(10.0, "length of a rollout", unit="s", ge=0.5, le=60)
    dt: float = option(
        STEP,
        "time step of the physics; 1/60 s must be a whole multiple of it",
        unit="s",
        ge=2e-4,
        le=1 / 60,
    )
    torque_limit: float = option(15.0, "largest torque of a servo", unit="N m", ge=0, le=1000)
    speed_limit: float = option(
        10.0, "largest angular speed of a servo", unit="rad/s", ge=0, le=100
    )
    friction: float = option(0.8, "coefficient of friction between feet and ground", ge=0, le=5)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)
    damage: tuple[str, ...] = option((), DAMAGE_HELP)
    world: dict[str, float] = option({}, WORLD_HELP)
    dimensions: dict[str, float] = option({}, DIMENSIONS_HELP)
    evolve: tuple[str, ...] = option((), EVOLVE_HELP)
    ranges: dict[str, tuple[float, float]] = option({}, RANGES_HELP)

    dynamic: ClassVar[bool] = True
    channels: ClassVar[Any] = EvolvingChannels(CHANNELS)

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_time_step(self.dt, FRAME_RATE)
        check_world(self.world, self.conditions())
        check_dimensions(DIMENSIONS, self.dimensions, self.evolve, self.ranges)
        _ = self._damage
        return self

    @property
    def plan(self) -> WalkerPlan:
        """Build of the body: its parts and their sizes, without evolved dimensions."""
        return plan_of(self.legs, **self.dimensions)

    def _plans(self, factors: Array) -> list[WalkerPlan]:
        """Return the build of each individual for evolved factors, (population, dimensions)."""
        own = [dict(zip(self.evolve, row, strict=True)) for row in factors.tolist()]
        return [plan_of(self.legs, **self.dimensions, **one) for one in own]

    def design_space(self) -> Mapping[str, Dimension]:
        """Return the lengths of thighs, shanks and trunk."""
        return DIMENSIONS

    @property
    def _damage(self) -> Impairment:
        return impairment_of(self.damage, self.plan)

    @property
    def frames(self) -> int:
        """Number of frames of a rollout, including the start."""
        return round(self.duration * FRAME_RATE) + 1

    def genome_space(self) -> RealSpace:
        """Return six genes per leg and the frequency.

        That makes 13 or 25 genes, or 7 or 13 in an alternating gait. The factors of dimensions that
        evolve come last.
        """
        genes = dimension_genes(DIMENSIONS, self.evolve, self.ranges)
        return genome_space((*self._gene_groups, *genes))

    def starts(self) -> Mapping[str, Array]:
        """Return a trot made by hand on four legs; no gait made by hand stays up on two."""
        if self.legs == 2:
            return {}
        start = trot(self.plan, self.symmetry == "alternating", self.fastest_stride)
        whole = np.append(start, np.ones(len(self.evolve)))
        return {"trot": self.genome_space().repair(whole[None])[0]}

    @property
    def _gene_groups(self) -> tuple[GeneGroup, ...]:
        return groups(self.plan, self.symmetry == "alternating", self.fastest_stride)

    def move(self, genomes: Genomes) -> Motion:
        """Simulate one individual after the other, each in its own space."""
        gait, factors = np.split(genomes, [genomes.shape[1] - len(self.evolve)], axis=1)
        groups, plans = self._gene_groups, self._plans(factors)
        angles = commands(plans, gait, groups, self.encoding, self.frames)
        *_, frequency = split_genomes(gait, groups)
        return self._walk(angles, frequency[:, 0], factors)

    def play(self, joint_angles: Array) -> Motion:
        """Walk with the given servo commands, clipped to ±60° (hips) and ±50° (knees).

        Args:
            joint_angles: commands relative to the stance at rest, (population, frames, joints)
                rad, at 60 frames per second; at least 2 frames, the first of which is the initial
                pose.
        """
        check_joint_angles(joint_angles, len(self.plan.joints))
        limits = self.plan.limits
        angles = np.clip(joint_angles.astype(np.float64), -limits, limits)
        frequency, factors = angles_frequency(angles, FRAME_RATE), (len(angles), len(self.evolve))
        return self._walk(angles, frequency, np.ones(factors))

    def physics_engine(self) -> str:
        """Return 'pymunk', which takes sines and cosines from the C library."""
        return "pymunk"

    def joint_names(self) -> tuple[str, ...]:
        """Return names such as 'near fore hip' and 'near fore knee'; 'near hip' on two legs."""
        return self.plan.joints

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return hip and knee of 'near' and 'far', or of 'near fore', 'near hind' …."""
        return {leg.name: (f"{leg.name} hip", f"{leg.name} knee") for leg in self.plan.legs}

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions: ground, masses, servos, initial pose and pushes."""
        return conditions(
            "friction",
            "mass",
            "latency",
            "servo_torque",
            "servo_speed",
            "joint_offset",
            "slope",
            "unevenness",
            "push",
            "initial_pose",
            frame_rate=FRAME_RATE,
            friction=self.friction,
        )

    def surroundings(self, frames: int) -> Surroundings:
        """Return the surroundings for a rollout of `frames` frames."""
        world = {name: one.nominal for name, one in self.conditions().items()} | self.world
        reach, joints = REACH * frames / FRAME_RATE, len(self.plan.joints)
        pushed_in, direction = draw_push(world, frames)
        return Surroundings(
            plan=self.plan,
            damage=self._damage,
            ground=ground(world["unevenness"], world_seed(world), reach),
            gravity=self.gravity,
            slope=math.radians(world["slope"]),
            friction=world["friction"],
            torque_limit=world["servo_torque"] * self.torque_limit,
            speed_limit=world["servo_speed"] * self.speed_limit,
            steps=round(1 / (FRAME_RATE * self.dt)),
            mass=world["mass"],
            latency=world["latency"],
            command_rate=world["command_rate"],
            joint_offset=draw_joint_errors(world, "joint_offset", joints),
            initial_pose=draw_joint_errors(world, "initial_pose", joints),
            # In the plane, a push goes either forward or backward.
            push=(pushed_in, math.copysign(world["push"], math.cos(direction))),
        )

    def _walk(self, commands: Floats, frequency: Floats, factors: Floats) -> Motion:
        """Return the motion of walkers.

        Args:
            commands: commands to the servos, (population, frames, joints) rad.
            frequency: stride frequency of the commands, (population,) Hz.
            factors: factors of the dimensions that evolve, (population, dimensions).
        """
        from gaitsim_walker.machine import walk

        surroundings = self.surroundings(commands.shape[1])
        restricted = surroundings.damage.restrict(commands)
        motion = walk(surroundings, self._plans(factors), restricted, frequency)
        if self.evolve:
            motion.add("dimensions", factors.copy())
        return motion

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return distance, duration, steadiness, effort, slip and steps."""
        return {**measures(motion, self.plan), **dimension_measures(self.evolve, motion)}

    def rig(self) -> Rig:
        """Return the torso, and thigh and shank of each leg, in the plane y = 0."""
        return rig(self.plan, self._damage.lost.tolist(), self._damage.parts)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the outline of the torso, and thigh and shank of each leg, in the plane y = 0.

        Gravity points down: the walker's frame is rotated by the slope of the ground.
        """
        if self.evolve:
            own, _ = self.embody(motion["dimensions"][individual])
            return own.skeleton(motion, individual)
        return skeleton(self.surroundings(motion["pitch"].shape[1]), motion, individual)
