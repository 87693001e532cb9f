"""The walker: a torso on two or four legs, seen from the side."""

import math
from collections.abc import Iterable, Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from gaitsim.contracts import (
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Genomes,
    Measure,
    Motion,
    Organism,
    RealSpace,
    Rig,
    Skeleton,
    check_world,
    option,
)
from gaitsim.encoding import GeneGroup, check_joint_angles, check_time_step, genome_space
from gaitsim.legged import conditions, drawn_push, joint_errors, seed_of
from gaitsim_walker.body import FRAME_RATE, PLANS, Floats, Plan
from gaitsim_walker.encodings import commands, groups
from gaitsim_walker.ground import ground
from gaitsim_walker.measures import measures
from gaitsim_walker.rig import rig
from gaitsim_walker.skeleton import skeleton
from gaitsim_walker.surroundings import STEP, Surroundings

REACH = 5.0  # m/s, the fastest walker that the uneven ground is long enough for
XYZ = ("x", "y", "z")


class Walker(Organism):
    """A torso on legs of thigh and shank in a vertical plane, in a rigid-body simulation."""

    legs: Literal[2, 4] = option(4, "how many legs: 4 under a level torso, 2 under an upright one")
    encoding: Literal["sine", "cpg"] = option(
        "sine",
        "how a genome becomes joint angles: sines at full swing from the start, or oscillators "
        "that start from standing",
    )
    symmetry: Literal["none", "alternating"] = option(
        "none",
        "alternating: the far legs do what the near ones do, half a stride later, and the genome "
        "has about half as many genes",
    )
    fastest_stride: float = option(
        2.5, "upper bound of the gene for strides a second", unit="Hz", gt=0.5, le=5
    )
    duration: float = option(10.0, "length of a rollout", unit="s", ge=0.5, le=60)
    dt: float = option(
        STEP,
        "time step of the physics, a whole number of which make 1/60 s",
        unit="s",
        ge=2e-4,
        le=1 / 60,
    )
    torque_limit: float = option(15.0, "largest torque of a servo", unit="N m", ge=0, le=1000)
    speed_limit: float = option(
        10.0, "largest angular speed that a servo asks for", unit="rad/s", ge=0, le=100
    )
    friction: float = option(0.8, "friction of the feet on the ground", ge=0, le=5)
    gravity: float = option(9.81, "acceleration of gravity", unit="m/s²", ge=0, le=100)
    world: dict[str, float] = option({}, WORLD_HELP)

    dynamic: ClassVar[bool] = True
    channels: ClassVar[Mapping[str, Channel]] = {
        "joint_angles": Channel(
            ("frames", "joints"), "rad", "commanded to the servos, from the stance at rest"
        ),
        "joint_positions": Channel(("frames", "joints"), "rad", "where the joints really are"),
        "torque": Channel(
            ("frames", "joints"), "N m", "magnitude of its mean since the frame before"
        ),
        "stall_torque": Channel(("joints",), "N m", "largest torque of the servos"),
        "torso": Channel(("frames", XYZ), "m", "middle of the torso; y is 0, z is up"),
        "torso_velocity": Channel(("frames", XYZ), "m/s", "of the middle of the torso"),
        "pitch": Channel(("frames",), "rad", "of the torso, nose up"),
        "orientation": Channel(
            ("frames", ("roll", "pitch", "yaw")), "rad", "to the right, nose down, to the left"
        ),
        "height": Channel(("frames",), "m", "middle of the torso above the ground under it"),
        "foot_positions": Channel(
            ("frames", "feet", XYZ), "m", "middles of the round feet, in the world"
        ),
        "stance": Channel(("frames", "feet"), "", "whether the foot is on the ground"),
        "load": Channel(("frames", "feet", ("x", "z")), "N", "force of the ground on each foot"),
        "slip": Channel(("frames",), "m", "mean slide of the stance feet since the frame before"),
        "energy": Channel(
            ("frames",), "J", "work of the servos since the start, braking counted as spent"
        ),
        "lasted": Channel((), "s", "time before the fall, or the whole rollout"),
        "weight": Channel((), "N", "of the whole body"),
        "length": Channel((), "m", "of the torso"),
    }

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_time_step(self.dt, FRAME_RATE)
        check_world(self.world, self.conditions())
        return self

    @property
    def plan(self) -> Plan:
        """The parts of the body and their sizes."""
        return PLANS[self.legs]

    @property
    def frames(self) -> int:
        """Number of frames of a rollout, its start included."""
        return round(self.duration * FRAME_RATE) + 1

    def genome_space(self) -> RealSpace:
        """Six genes a leg and the frequency: 13 or 25 genes, in an alternating gait 7 or 13."""
        return genome_space(self._gene_groups)

    @property
    def _gene_groups(self) -> tuple[GeneGroup, ...]:
        return groups(self.plan, self.symmetry == "alternating", self.fastest_stride)

    def move(self, genomes: Genomes) -> Motion:
        """Walk, one individual after the other, each in a space of its own."""
        courses = commands(self.plan, genomes, self._gene_groups, self.encoding, self.frames)
        return self._walked(courses, self.frames)

    def play(self, joint_angles: Array) -> Motion:
        """Walk by commands to the servos, clipped to ±60° (hips) and ±50° (knees).

        Args:
            joint_angles: (population, frames, joints), radians from the stance at rest, 60 frames
                a second, of any number of frames from 2; the first is the pose at the start.

        Raises:
            ValueError: another shape, or angles that are not finite.
        """
        check_joint_angles(joint_angles, len(self.plan.joints))
        limits = self.plan.limits
        return self._walked(
            (np.clip(course.astype(np.float64), -limits, limits) for course in joint_angles),
            joint_angles.shape[1],
        )

    def joint_names(self) -> tuple[str, ...]:
        """'near fore hip', 'near fore knee', 'near hind hip' …; 'near hip' … of two legs."""
        return self.plan.joints

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """'near' and 'far', or 'near fore', 'near hind' …, each with its hip and knee."""
        return {leg.name: (f"{leg.name} hip", f"{leg.name} knee") for leg in self.plan.legs}

    def conditions(self) -> Mapping[str, Condition]:
        """What may vary: the ground, masses, servos, the pose at the start, and pushes."""
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
        """Return what a walker walks in, for a number of frames."""
        world = {name: one.nominal for name, one in self.conditions().items()} | self.world
        reach, joints = REACH * frames / FRAME_RATE, len(self.plan.joints)
        pushed_in, direction = drawn_push(world, frames)
        return Surroundings(
            plan=self.plan,
            ground=ground(world["unevenness"], seed_of(world), reach),
            gravity=self.gravity,
            slope=math.radians(world["slope"]),
            friction=world["friction"],
            torque_limit=world["servo_torque"] * self.torque_limit,
            speed_limit=world["servo_speed"] * self.speed_limit,
            steps=round(1 / (FRAME_RATE * self.dt)),
            mass=world["mass"],
            latency=world["latency"],
            command_rate=world["command_rate"],
            joint_offset=joint_errors(world, "joint_offset", joints),
            initial_pose=joint_errors(world, "initial_pose", joints),
            # In a plane there is only forward and backward.
            push=(pushed_in, math.copysign(world["push"], math.cos(direction))),
        )

    def _walked(self, courses: Iterable[Floats], frames: int) -> Motion:
        """Return the motion of walkers whose servos follow courses, (frames, joints) rad."""
        from gaitsim_walker.motion import walked

        return walked(self.surroundings(frames), courses)

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Distance, how long it lasted, steadiness, effort, slip and steps."""
        return measures(motion, self.plan)

    def rig(self) -> Rig:
        """The torso, and thigh and shank of each leg, in the plane y = 0."""
        return rig(self.plan)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Outline of the torso, and thigh and shank of each leg, in the plane y = 0.

        Gravity points down: where the ground has a slope, the walker's frame is turned by it.
        """
        return skeleton(self.surroundings(motion["pitch"].shape[1]), motion, individual)
