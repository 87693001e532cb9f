"""The spider: a body of eight legs with three joints each."""

from collections.abc import Mapping
from functools import partial
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from gaitsim.contracts import (
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Genomes,
    GenomeSpace,
    Measure,
    Motion,
    Organism,
    Rig,
    Skeleton,
    check_world,
    option,
)
from gaitsim.encoding import check_joint_angles, limit_steps
from gaitsim.legged import BODY_HEIGHT, DAMAGE_HELP, stepping
from gaitsim_spider import body
from gaitsim_spider.damage import Anatomy, Legs, anatomy
from gaitsim_spider.encodings import ENCODINGS, Angles
from gaitsim_spider.layout import time_last, time_second
from gaitsim_spider.worlds import CONDITIONS, LEG_MASS, joint_positions

XYZ = ("x", "y", "z")


class Spider(Organism):
    """An eight-legged spider with three joints a leg, walking on flat ground."""

    encoding: Literal["sine", "cpg", "recurrence"] = option(
        "sine",
        "how a genome becomes joint angles: a sine a joint, coupled phase oscillators, or "
        "a linear recurrence",
    )
    frequency: float = option(
        1.5, "strides a second of the sine and cpg encodings", unit="Hz", ge=0.2, le=5.0
    )

    symmetry: Literal["none", "alternating"] = option(
        "none",
        "alternating: the right legs do what the left ones do, half a stride later, and the "
        "genome has half as many genes; not with the recurrence",
    )
    damage: tuple[str, ...] = option((), DAMAGE_HELP)
    world: dict[str, float] = option({}, WORLD_HELP)

    threads: ClassVar[bool] = True
    twin: ClassVar[str] = "spider-physics"
    channels: ClassVar[Mapping[str, Channel]] = {
        "joint_angles": Channel(("frames", "joints"), "rad", "commanded, from the pose at rest"),
        "joint_positions": Channel(("frames", "joints"), "rad", "where the joints are"),
        "feet": Channel(("frames", "feet", XYZ), "m", "feet in the body's frame"),
        "centre_of_mass": Channel(("frames", XYZ), "m", "in the body's frame"),
        "pose": Channel(
            ("frames", ("x", "y", "yaw")), ("m", "m", "rad"), "of the body in the world"
        ),
        "stance": Channel(("frames", "feet"), "", "whether the foot stays until the next frame"),
        "slip": Channel(("frames",), "m", "mean slide of the stance feet until the next frame"),
        "margin": Channel(("frames",), "m", "static stability margin, negative when unsupported"),
        "slope": Channel(("frames",), "rad", "tilt of the plane on which the feet rest"),
    }

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.encoding == "recurrence" and self.symmetry != "none":
            raise ValueError("symmetry 'alternating' needs the encoding 'sine' or 'cpg'")
        anatomy(self.damage)
        check_world(self.world, CONDITIONS)
        return self

    def genome_space(self) -> GenomeSpace:
        """48 genes, two a joint in any encoding; 24 in an alternating gait."""
        return ENCODINGS[self.encoding].space(self.frequency, self.symmetry == "alternating")

    def move(self, genomes: Genomes) -> Motion:
        """Decode to joint angles, as far as damaged joints reach them, and walk."""
        alternating = self.symmetry == "alternating"
        angles = ENCODINGS[self.encoding].angles(genomes, self.frequency, alternating)
        return self._walked(self._left.restrict(angles))

    def play(self, joint_angles: Array) -> Motion:
        """Walk by given joint angles, held to ±30° and, from frame to frame, to 5° or less if slow.

        Args:
            joint_angles: (population, frames, 24), radians from the pose at rest, of any
                number of frames from 2; the body can begin in any pose within its limits.

        Raises:
            ValueError: another shape, or angles that are not finite.
        """
        check_joint_angles(joint_angles, len(body.JOINTS))
        limit = np.float32(body.ANGLE_LIMIT)
        angles = np.clip(joint_angles, -limit, limit).astype(np.float32)
        left = self._left
        angles = limit_steps(time_last(angles), left.step_limits)
        return self._walked(left.restrict(angles))

    @property
    def _left(self) -> Anatomy:
        """What damage and the world leave of the body."""
        return anatomy(self.damage, self.world.get(LEG_MASS, 1.0))

    def _walked(self, commands: Angles) -> Motion:
        """Return the motion by commands, (population, 24, frames) rad."""
        left = self._left
        positions = joint_positions(commands, self.world, left.step_limits)
        if positions is not commands:
            positions = left.restrict(positions)
        return _walked(commands, positions, left.legs)

    def joint_names(self) -> tuple[str, ...]:
        """'L1 coxa', 'L1 femur', 'L1 tibia', 'L2 coxa' … 'R4 tibia'."""
        return body.JOINTS

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """L1 … R4, each with its coxa, femur and tibia."""
        return body.LEG_JOINTS

    def conditions(self) -> Mapping[str, Condition]:
        """What may vary without forces: how joints follow their commands, and mass of the legs."""
        return CONDITIONS

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Travel, heading, slip, stability and stance over the whole gait."""
        pose = motion["pose"]
        forward = pose[:, -1, 0]

        def slip_ratio() -> Array:
            path = np.linalg.norm(np.diff(pose[:, :, :2], axis=1), axis=2).sum(axis=1)
            slid = motion["slip"][:, :-1].sum(axis=1)
            ratio: Array = np.full_like(slid, np.inf)
            np.divide(slid, path, out=ratio, where=path > 0)
            return ratio

        return {
            "forward": Measure(forward, "m", "in the gait's 10 s, along the starting heading"),
            "body lengths": Measure(forward / body.BODY_LENGTH, "", "forward in body lengths"),
            "lateral": Measure(pose[:, -1, 1], "m", "displacement to the left"),
            "yaw": Measure(np.degrees(pose[:, -1, 2]), "°", "turn to the left"),
            "slip ratio": Measure(slip_ratio, "", "distance the stance feet slid, over the path"),
            "least margin": Measure(
                lambda: 1000 * motion["margin"].min(axis=1),
                "mm",
                "static stability, worst moment: centre of mass to the edge of support",
            ),
            BODY_HEIGHT: Measure(
                partial(_height, motion), "m", "of the body's middle above the ground, mean"
            ),
            **stepping(motion["stance"], body.LEGS, motion.frame_rate, sides=body.SIDES),
        }

    def rig(self) -> Rig:
        """The trunk's outline, and coxa, femur and tibia of each leg."""
        from gaitsim_spider.rig import rig

        return rig(self._left)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Body outline and legs in the world, standing on z = 0."""
        from gaitsim_spider.kinematics import leg_points

        left = self._left
        points = leg_points(motion["joint_positions"][individual])
        points[:, left.lost, 1:] = points[:, left.lost, :1]
        x, y, yaw = (motion["pose"][individual, :, axis].astype(float) for axis in range(3))
        outline = np.broadcast_to(body.OUTLINE, (len(points), 4, 2, 3))
        legs = np.stack([points[:, :, :-1], points[:, :, 1:]], axis=3).reshape(
            len(points), 24, 2, 3
        )
        middle = motion["centre_of_mass"][individual].astype(float)
        points = np.concatenate(
            [*(part.reshape(len(points), -1, 3) for part in (outline, legs)), middle[:, None]],
            axis=1,
        )
        cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        world = np.stack(
            [
                x[:, None] + cos * points[..., 0] - sin * points[..., 1],
                y[:, None] + sin * points[..., 0] + cos * points[..., 1],
                points[..., 2],
            ],
            axis=-1,
        )
        world[..., 2] += body.FOOT_RADIUS - world[:, :-1, 2].min(axis=1)[:, None]
        segments = world[:, :-1].reshape(len(points), -1, 2, 3)
        feet = segments[:, 4:].reshape(len(points), 8, 3, 2, 3)[:, :, 2, 1]
        names = np.array([*body.OUTLINE_NAMES, *body.JOINTS])
        drawn = np.repeat([True, *~left.lost], [4, *[3] * 8])
        return Skeleton(
            segments=segments[:, drawn],
            names=tuple(names[drawn].tolist()),
            frame_rate=motion.frame_rate,
            contacts=feet,
            touching=motion["stance"][individual],
            contact_names=body.LEGS,
            centre=world[:, -1],
            damaged=left.damaged,
        )


def _height(motion: Motion) -> Array:
    """Mean height of the body's middle above the lowest foot's ground, (population,) m."""
    lowest = motion["feet"][..., 2].min(axis=2)
    return np.asarray(body.FOOT_RADIUS - lowest.mean(axis=1, dtype=np.float64))


def _walked(commands: Angles, angles: Angles, legs: Legs) -> Motion:
    """Return the motion of joints; feet, contact and travel are worked out when first read.

    Args:
        commands: (population, 24, frames) rad.
        angles: where the joints are, likewise.
        legs: what damage leaves of them.
    """
    population, _, frames = angles.shape

    def place() -> dict[str, Array]:
        from gaitsim_spider.kinematics import place_feet

        feet = np.empty((population, 3, 8, frames), dtype=np.float32)
        centre = np.empty((population, 3, frames), dtype=np.float32)
        place_feet(angles, legs, feet, centre)
        return {"feet": time_second(feet), "centre_of_mass": time_second(centre)}

    def travel() -> dict[str, Array]:
        from gaitsim_spider.walking import walk

        pose = np.empty((population, 3, frames), dtype=np.float32)
        stance = np.empty((population, 8, frames), dtype=np.bool_)
        slip, margin, slope = np.empty((3, population, frames), dtype=np.float32)
        walk(angles, legs, pose, stance, slip, margin, slope)
        return {
            "pose": time_second(pose),
            "stance": time_second(stance),
            "slip": slip,
            "margin": margin,
            "slope": slope,
        }

    return Motion(
        body.FRAME_RATE,
        {"joint_angles": time_second(commands), "joint_positions": time_second(angles)},
        {
            ("feet", "centre_of_mass"): place,
            ("pose", "stance", "slip", "margin", "slope"): travel,
        },
    )
