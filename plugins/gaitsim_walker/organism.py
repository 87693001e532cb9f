"""The walker: a torso on two or four legs, seen from the side."""

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from gaitsim.contracts import (
    Array,
    Channel,
    Genomes,
    Measure,
    Motion,
    Organism,
    RealSpace,
    Skeleton,
    option,
)
from gaitsim.encoding import GeneGroup, genome_space
from gaitsim_walker import body
from gaitsim_walker.body import FRAME_RATE, PLANS, Floats, Plan
from gaitsim_walker.encodings import commands, groups
from gaitsim_walker.ground import ground
from gaitsim_walker.world import STEP, World

if TYPE_CHECKING:
    from gaitsim_walker.rollout import Rollout

REACH = 5.0  # m/s; ground is laid for walkers as fast as that
XYZ = ("x", "y", "z")


class Walker(Organism):
    """A torso on legs of thigh and shank in a vertical plane, in a rigid-body simulation."""

    legs: Literal[2, 4] = option(4, "how many legs: 4 under a level torso, 2 under an upright one")
    encoding: Literal["sine", "cpg"] = option(
        "sine",
        "how a genome becomes joint angles: sines at full swing from the start, or oscillators "
        "that begin at rest",
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
    roughness: float = option(
        0.0,
        "height of the highest bumps of the ground, a corner each 25 cm",
        unit="m",
        ge=0,
        le=0.2,
    )
    ground_seed: int = option(0, "seed of the bumps, the same ground for everyone", ge=0)

    dynamic: ClassVar[bool] = True
    channels: ClassVar[Mapping[str, Channel]] = {
        "joint_angles": Channel(
            ("frames", "joints"), "rad", "commanded to the servos, from the stance at rest"
        ),
        "joint_positions": Channel(("frames", "joints"), "rad", "where the joints really are"),
        "torque": Channel(
            ("frames", "joints"), "N m", "magnitude of its mean since the frame before"
        ),
        "torso": Channel(("frames", XYZ), "m", "middle of the torso; y is 0, z is up"),
        "torso_velocity": Channel(("frames", XYZ), "m/s", "of the middle of the torso"),
        "pitch": Channel(("frames",), "rad", "of the torso, nose up"),
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
    }

    @model_validator(mode="after")
    def _check(self) -> Self:
        steps = 1 / (FRAME_RATE * self.dt)
        if not math.isclose(steps, round(steps), rel_tol=1e-3):
            near = 1 / (FRAME_RATE * round(steps))
            raise ValueError(
                f"dt {self.dt:g} s makes no whole number of steps in 1/60 s; {near:.4g} s does"
            )
        return self

    @property
    def plan(self) -> Plan:
        """What the body looks like."""
        return PLANS[self.legs]

    @property
    def frames(self) -> int:
        """Frames of a rollout, its start counted."""
        return round(self.duration * FRAME_RATE) + 1

    def genome_space(self) -> RealSpace:
        """Six genes a leg and the frequency: 13 or 25 genes, in an alternating gait 7 or 13."""
        return genome_space(self._gene_groups)

    @property
    def _gene_groups(self) -> tuple[GeneGroup, ...]:
        return groups(self.plan, self.symmetry == "alternating", self.fastest_stride)

    def move(self, genomes: Genomes) -> Motion:
        """Walk, one after the other, each in a space of its own."""
        told = commands(self.plan, genomes, self._gene_groups, self.encoding, self.frames)
        return self._walked(told, self.frames)

    def play(self, joint_angles: Array) -> Motion:
        """Walk by what the servos are told, held to ±60° (hips) and ±50° (knees).

        Args:
            joint_angles: (population, frames, joints), radians from the stance at rest, 60 frames
                a second, of any number of frames from 2; the first is the pose at the start.

        Raises:
            ValueError: another shape, or angles that are not finite.
        """
        joints = len(self.plan.joints)
        if joint_angles.ndim != 3 or joint_angles.shape[1] < 2 or joint_angles.shape[2] != joints:
            raise ValueError(
                f"joint_angles has the shape {joint_angles.shape}, expected (population, frames, "
                f"joints) with at least 2 frames and {joints} joints"
            )
        if not np.isfinite(joint_angles).all():
            raise ValueError("joint_angles holds values that are not finite")
        limits = self.plan.limits
        return self._walked(
            (np.clip(told.astype(np.float64), -limits, limits) for told in joint_angles),
            joint_angles.shape[1],
        )

    def joint_names(self) -> tuple[str, ...]:
        """'near fore hip', 'near fore knee', 'near hind hip' …; 'near hip' … of two legs."""
        return self.plan.joints

    def world(self, frames: int) -> World:
        """What a walker walks in, for so many frames."""
        reach = REACH * frames / FRAME_RATE
        return World(
            self.plan,
            ground(self.roughness, self.ground_seed, reach),
            self.gravity,
            self.friction,
            self.torque_limit,
            self.speed_limit,
            round(1 / (FRAME_RATE * self.dt)),
        )

    def _walked(self, courses: Iterable[Floats], frames: int) -> Motion:
        """The motion by what the servos are told, (frames, joints) rad of each individual."""
        from gaitsim_walker.rollout import roll_out

        world = self.world(frames)
        told, rolled = [], []
        for course in courses:
            rollout = roll_out(world, course)
            held = course.copy()
            held[rollout.lasted :] = course[min(rollout.lasted, frames - 1)]
            told.append(held)
            rolled.append(rollout)
        seen = [_seen(world, rollout) for rollout in rolled]

        def all_of(name: str) -> Array:
            return np.stack([getattr(rollout, name) for rollout in rolled])

        position, velocity = (
            _in_space(all_of("position")),
            _in_space(all_of("velocity")),
        )
        load = all_of("load")
        lasted = np.array([max(rollout.lasted, 1) - 1 for rollout in rolled]) / FRAME_RATE
        return Motion(
            FRAME_RATE,
            {
                "joint_angles": np.stack(told),
                "joint_positions": all_of("joints"),
                "torque": all_of("torque"),
                "torso": position,
                "torso_velocity": velocity,
                "pitch": all_of("pitch"),
                "height": np.stack([height for height, _, _ in seen]),
                "foot_positions": np.stack([feet for _, feet, _ in seen]),
                "stance": load[..., 1] > 0,
                "load": load,
                "slip": np.stack([slip for _, _, slip in seen]),
                "energy": all_of("work"),
                "lasted": lasted,
            },
            failures={i: rollout.failure for i, rollout in enumerate(rolled) if rollout.failure},
        )

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Distance, how long it lasted, steadiness, effort, slip and duty factor."""
        forward = motion["torso"][:, -1, 0] - motion["torso"][:, 0, 0]
        lasted, energy = motion["lasted"], motion["energy"][:, -1]
        weight = self.plan.mass * self.gravity
        path = np.abs(np.diff(motion["torso"][..., 0], axis=1)).sum(axis=1)
        pitch = np.degrees(motion["pitch"])
        return {
            "forward": Measure(forward, "m", "displacement of the torso"),
            "body lengths": Measure(
                forward / body.TORSO_LENGTH,
                "",
                f"forward in torsos of {body.TORSO_LENGTH:g} m",
            ),
            "lasted": Measure(lasted, "s", "before the fall, or the whole rollout"),
            "cost of transport": Measure(
                _ratio(energy, weight * np.abs(forward)),
                "",
                "work over weight times distance",
            ),
            "pitch range": Measure(
                np.ptp(pitch, axis=1), "°", "between its highest and lowest nose"
            ),
            "torso height": Measure(
                motion["height"].mean(axis=1), "m", "of its middle above the ground, mean"
            ),
            "slip ratio": Measure(
                _ratio(motion["slip"].sum(axis=1), path),
                "",
                "slide of the stance feet over path",
            ),
            "duty factor": Measure(
                motion["stance"].mean(axis=(1, 2)),
                "",
                "share of time that a foot is on the ground",
            ),
        }

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Outline of the torso, and thigh and shank of each leg, in the plane y = 0.

        z = 0 is the lowest ground that there is.
        """
        position, pitch = motion["torso"][individual], motion["pitch"][individual]
        lie = self.world(len(pitch)).ground
        half_x, half_z = self.plan.half
        corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * [half_x, half_z]
        cos, sin = np.cos(pitch)[:, None], np.sin(pitch)[:, None]
        outline = np.stack(
            [
                cos * corners[:, 0] - sin * corners[:, 1],
                sin * corners[:, 0] + cos * corners[:, 1],
            ],
            axis=-1,
        )
        outline += position[:, None, [0, 2]]
        where = body.points(
            self.plan, position[:, [0, 2]], pitch, motion["joint_positions"][individual]
        )
        limbs = np.stack([where[:, :, :-1], where[:, :, 1:]], axis=3)
        edges = np.stack([outline, np.roll(outline, -1, axis=1)], axis=2)
        segments = np.concatenate([edges, limbs.reshape(len(pitch), -1, 2, 2)], axis=1)
        names = [f"{leg.name} {part}" for leg in self.plan.legs for part in ("thigh", "shank")]
        return Skeleton(
            _in_space(segments),
            ("front", "bottom", "back", "top", *names),
            motion.frame_rate,
            contacts=motion["foot_positions"][individual],
            touching=motion["stance"][individual],
            contact_names=tuple(leg.name for leg in self.plan.legs),
            centre=position,
            ground=np.column_stack([lie.x, lie.z]) if self.roughness else None,
        )


def _seen(world: World, rollout: "Rollout") -> tuple[Floats, Floats, Floats]:
    """Height, (frames,), feet, (frames, legs, 3), and slip, (frames,), of one walker.

    Worked out for each alone, so that all arrays have one shape whoever else is moved.
    """
    plan = world.plan
    feet = body.points(plan, rollout.position, rollout.pitch, rollout.joints)[:, :, 2]
    turned = body.limb_angles(plan, rollout.joints)[:, 1::2] + rollout.pitch[:, None]
    # A round foot that rolls without sliding goes back as its shank turns forward.
    slid = np.abs(np.diff(feet[..., 0], axis=0) + body.FOOT_RADIUS * np.diff(turned, axis=0))
    stance = rollout.load[..., 1] > 0
    standing = stance[1:] & stance[:-1]
    slip = np.zeros(len(feet))
    slip[1:] = (slid * standing).sum(axis=1) / np.maximum(standing.sum(axis=1), 1)
    below = [world.ground.height(x) for x in rollout.position[:, 0].tolist()]
    return rollout.position[:, 1] - np.array(below), _in_space(feet), slip


def _in_space(flat: Array) -> Array:
    """Put y = 0 between x and z, (…, 2) -> (…, 3)."""
    whole = np.zeros((*flat.shape[:-1], 3))
    whole[..., 0], whole[..., 2] = flat[..., 0], flat[..., 1]
    return whole


def _ratio(part: Array, whole: Array) -> Array:
    """Part over whole; infinite where there is no whole."""
    ratio: Array = np.divide(part, whole, out=np.full(len(part), math.inf), where=whole > 0)
    return ratio
