"""The spider: a body of eight legs with three joints each."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
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
    GenomeSpace,
    Link,
    Measure,
    Motion,
    Organism,
    Rig,
    Skeleton,
    check_dimensions,
    check_world,
    dimension_measures,
    option,
    product,
    rotated,
    turn_about,
    turn_about_axis,
)
from gaitsim.plugin.toolkit import (
    BODY_HEIGHT,
    DAMAGE_HELP,
    STRIDE_FREQUENCY,
    STRIDE_FREQUENCY_CHANNEL,
    GeneGroup,
    angles_frequency,
    check_joint_angles,
    conditions,
    delay_angles,
    dimension_genes,
    downward,
    draw_joint_errors,
    genome_space,
    hold_commands,
    limit_steps,
    norm,
    place_on_slope,
    split_genomes,
    stepping_measures,
)
from gaitsim_spider import body
from gaitsim_spider.body import time_last, time_second
from gaitsim_spider.damage import LegData, SpiderAnatomy, anatomy_of
from gaitsim_spider.encodings import ENCODINGS, Angles, tetrapod

LEG_MASS = "leg_mass"
SLOPES = ("slope", "side_slope")

CONDITIONS: Mapping[str, Condition] = {
    **conditions(
        "latency",
        "servo_speed",
        "joint_offset",
        "initial_pose",
        *SLOPES,
        frame_rate=body.FRAME_RATE,
    ),
    LEG_MASS: Condition(
        "", 1.0, 0.8, 1.2, 0.0, 10.0, "scale factor of the legs' masses (moves the centre of mass)"
    ),
}


def joint_positions(
    commands: NDArray[np.float32], world: Mapping[str, float], step_limits: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return the positions of joints that follow commands in a world.

    Each command is held until the next one arrives, after the latency. The servos have a limited
    speed and constant errors, and stay within ±30°. In the nominal world, returns `commands`
    itself.

    Args:
        commands: commanded angles, (population, joints, frames) rad.
        world: values by the names of conditions.
        step_limits: largest rotation of each joint per frame at full speed, (joints,) rad.

    Returns:
        (population, joints, frames) rad.
    """
    values = {**_NOMINAL, **{name: world[name] for name in _NOMINAL if name in world}}
    if values == _NOMINAL:
        return commands
    joints = commands.shape[1]
    by_frame = np.ascontiguousarray(commands.swapaxes(1, 2))
    sent = hold_commands(by_frame, body.FRAME_RATE, values["command_rate"])
    arrived = delay_angles(sent, values["latency"] * body.FRAME_RATE).swapaxes(1, 2).copy()
    arrived[..., 0] += draw_joint_errors(world, "initial_pose", joints)
    turned = limit_steps(arrived, values["servo_speed"] * step_limits)
    turned += draw_joint_errors(world, "joint_offset", joints).astype(turned.dtype)[:, None]
    limit = np.float32(body.ANGLE_LIMIT)
    return np.asarray(np.clip(turned, -limit, limit, out=turned), np.float32)


_NOMINAL = {
    name: one.nominal for name, one in CONDITIONS.items() if name not in (LEG_MASS, *SLOPES)
}


TRUNK = "body"


def rig(anatomy: SpiderAnatomy) -> Rig:
    """Return the rig of the body without its lost legs.

    A coxa turns about the vertical, femur and tibia about the leg's sideways axis. The x axis of
    each link's frame points outward along the link.
    """
    links, names, ends, carriers = (
        [Link(TRUNK)],
        list(body.OUTLINE_NAMES),
        [*body.OUTLINE],
        [TRUNK] * 4,
    )
    feet, foot_links = [], []
    [hip_x], [hip_y] = anatomy.sizes.hip_x.tolist(), anatomy.sizes.hip_y.tolist()
    [lengths] = anatomy.sizes.lengths.tolist()
    for leg, lost in zip(range(len(body.LEGS)), anatomy.lost, strict=True):
        side = float(body.SIDE[leg])
        hip = (hip_x[leg], side * hip_y[leg], 0.0)
        if lost:
            feet.append(hip)
            foot_links.append(TRUNK)
            continue
        coxa, femur, tibia = body.LEG_JOINTS[body.LEGS[leg]]
        outward = side * (math.pi / 2 - float(body.AZIMUTH[leg]))
        up, tips = (0.0, -1.0, 0.0), [(length, 0.0, 0.0) for length in lengths[leg]]
        down, bend = -body.FEMUR_PITCH, body.FEMUR_PITCH - body.TIBIA_PITCH
        links += [
            Link(coxa, TRUNK, hip, turn_about_axis(2, outward), coxa, (0.0, 0.0, -side)),
            Link(femur, coxa, tips[0], turn_about_axis(1, down), femur, up),
            Link(tibia, femur, tips[1], turn_about_axis(1, bend), tibia, up),
        ]
        for name, tip in zip((coxa, femur, tibia), tips, strict=True):
            names.append(name)
            ends.append(np.array([(0.0, 0.0, 0.0), tip]))
            carriers.append(name)
        feet.append(tips[2])
        foot_links.append(tibia)
    return Rig(
        tuple(links),
        body.JOINTS,
        tuple(names),
        np.array(ends),
        tuple(carriers),
        np.array(feet),
        tuple(foot_links),
        body.LEGS,
        damaged=anatomy.damaged,
    )


XYZ = ("x", "y", "z")
CHANNELS: Mapping[str, Channel] = {
    "joint_angles": Channel(("frames", "joints"), "rad", "commands, from the pose at rest"),
    "joint_positions": Channel(("frames", "joints"), "rad", "positions of the joints"),
    "feet": Channel(("frames", "feet", XYZ), "m", "feet in the body's frame"),
    "centre_of_mass": Channel(("frames", XYZ), "m", "centre of mass in the body's frame"),
    "pose": Channel(
        ("frames", ("x", "y", "yaw")), ("m", "m", "rad"), "pose of the body in the world"
    ),
    "stance": Channel(
        ("frames", "feet"), "", "whether the foot stays in place until the next frame"
    ),
    "slip": Channel(("frames",), "m", "mean slide of the stance feet until the next frame"),
    "margin": Channel(("frames",), "m", "static stability margin, negative if unsupported"),
    "slope": Channel(("frames",), "rad", "tilt of the plane on which the feet rest"),
    STRIDE_FREQUENCY: STRIDE_FREQUENCY_CHANNEL,
}


class Spider(Organism):
    """An eight-legged spider with three joints per leg, walking on flat ground."""

    encoding: Literal["sine", "cpg", "recurrence"] = option(
        "sine",
        "rule that turns a genome into joint angles: 'sine' gives each joint a sine wave, 'cpg' "
        "uses coupled oscillators, 'recurrence' a linear recurrence",
    )
    frequency: float = option(
        1.5, "strides per second with the encodings 'sine' and 'cpg'", unit="Hz", ge=0.2, le=5.0
    )

    symmetry: Literal["none", "alternating"] = option(
        "none",
        "symmetry of the gait: with 'alternating', the right legs repeat the left legs' "
        "motion half a stride later, which halves the number of genes; not available "
        "with the encoding 'recurrence'",
    )
    damage: tuple[str, ...] = option((), DAMAGE_HELP)
    world: dict[str, float] = option({}, WORLD_HELP)
    dimensions: dict[str, float] = option({}, DIMENSIONS_HELP)
    evolve: tuple[str, ...] = option((), EVOLVE_HELP)
    ranges: dict[str, tuple[float, float]] = option({}, RANGES_HELP)

    portable: ClassVar[bool] = True
    threads: ClassVar[bool] = True
    twin: ClassVar[str] = "spider-physics"
    channels: ClassVar[Any] = EvolvingChannels(CHANNELS)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.encoding == "recurrence" and self.symmetry != "none":
            raise ValueError("symmetry 'alternating' needs the encoding 'sine' or 'cpg'")
        anatomy_of({}, self.damage)
        check_world(self.world, CONDITIONS)
        check_dimensions(body.DIMENSIONS, self.dimensions, self.evolve, self.ranges)
        return self

    def design_space(self) -> Mapping[str, Dimension]:
        """Return the lengths of the segments, of all legs, a row or a leg, and of the hips."""
        return body.DIMENSIONS

    @property
    def _gene_groups(self) -> tuple[GeneGroup, ...]:
        groups = ENCODINGS[self.encoding].groups(self.frequency, self.symmetry == "alternating")
        return (*groups, *dimension_genes(body.DIMENSIONS, self.evolve, self.ranges))

    def genome_space(self) -> GenomeSpace:
        """Return the space of 48 genes, two per joint in any encoding; 24 for alternating gaits.

        The factors of dimensions that evolve come last.
        """
        return genome_space(self._gene_groups)

    def starts(self) -> Mapping[str, Array]:
        """Return an alternating tetrapod made by hand; {} with the encoding 'recurrence'."""
        if self.encoding == "recurrence":
            return {}
        start = tetrapod(self.frequency, self.symmetry == "alternating")
        space = self.genome_space()
        return {"tetrapod": space.repair(np.append(start, np.ones(len(self.evolve)))[None])[0]}

    def unfold(self, genomes: Genomes) -> Genomes | None:
        """Return the genomes with the genes of all legs; None without symmetry."""
        if self.symmetry == "none":
            return None
        return np.concatenate(split_genomes(genomes, self._gene_groups), axis=1)

    def move(self, genomes: Genomes) -> Motion:
        """Walk with the joint angles that genomes decode to, as far as damaged joints allow."""
        alternating, genes = self.symmetry == "alternating", genomes.shape[1] - len(self.evolve)
        angles = ENCODINGS[self.encoding].angles(genomes[:, :genes], self.frequency, alternating)
        known = 0.0 if self.encoding == "recurrence" else self.frequency
        frequency = np.full(len(genomes), known)
        return self._walk(self._anatomy.restrict(angles), lambda: frequency, genomes[:, genes:])

    def play(self, joint_angles: Array) -> Motion:
        """Walk with given joint angles.

        Angles are clipped to ±30°, and their change per frame to 5°, or less for slow joints.

        Args:
            joint_angles: angles from the pose at rest, (population, frames, 24), radians, with at
                least 2 frames; the first pose may be any within the limits.
        """
        check_joint_angles(joint_angles, len(body.JOINTS))
        limit = np.float32(body.ANGLE_LIMIT)
        angles = np.clip(joint_angles, -limit, limit).astype(np.float32)
        anatomy = self._anatomy
        angles = limit_steps(time_last(angles), anatomy.step_limits)
        frequency = partial(angles_frequency, joint_angles, body.FRAME_RATE)
        factors = np.ones((len(angles), len(self.evolve)))
        return self._walk(anatomy.restrict(angles), frequency, factors)

    @property
    def _anatomy(self) -> SpiderAnatomy:
        """Anatomy of the damaged body with the world's masses, without evolved dimensions."""
        return anatomy_of(self.dimensions, self.damage, self.world.get(LEG_MASS, 1.0))

    def _walk(self, commands: Angles, frequency: Callable[[], Array], factors: Array) -> Motion:
        """Return a motion.

        Args:
            commands: commanded angles, (population, 24, frames) rad.
            frequency: returns the stride frequency of the commands, (population,) Hz.
            factors: factors of the dimensions that evolve, (population, dimensions).
        """
        own = {**self.dimensions, **dict(zip(self.evolve, factors.T, strict=True))}
        anatomy = anatomy_of(own, self.damage, self.world.get(LEG_MASS, 1.0))
        positions = joint_positions(commands, self.world, anatomy.step_limits)
        if positions is not commands:
            positions = anatomy.restrict(positions)
        motion = _motion(commands, positions, anatomy.legs, downward(self.world), frequency)
        if self.evolve:
            motion.add("dimensions", factors.copy())
        return motion

    def joint_names(self) -> tuple[str, ...]:
        """Return 'L1 coxa', 'L1 femur', 'L1 tibia', 'L2 coxa' … 'R4 tibia'."""
        return body.JOINTS

    def leg_joints(self) -> Mapping[str, tuple[str, ...]]:
        """Return the coxa, femur and tibia of each leg, L1 … R4."""
        return body.LEG_JOINTS

    def conditions(self) -> Mapping[str, Condition]:
        """Return the conditions without forces: joints, slopes and the mass of the legs."""
        return CONDITIONS

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return travel, heading, slip, stability and stance over the whole gait."""
        pose = motion["pose"]
        forward = pose[:, -1, 0]

        def slip_ratio() -> Array:
            path = norm(np.diff(pose[:, :, :2], axis=1)).sum(axis=1)
            slid = motion["slip"][:, :-1].sum(axis=1)
            ratio: Array = np.full_like(slid, np.inf)
            np.divide(slid, path, out=ratio, where=path > 0)
            return ratio

        return {
            **dimension_measures(self.evolve, motion),
            "forward": Measure(forward, "m", "distance in 10 s along the initial heading"),
            "body lengths": Measure(forward / body.BODY_LENGTH, "", "distance in body lengths"),
            "lateral": Measure(pose[:, -1, 1], "m", "displacement to the left"),
            "yaw": Measure(np.degrees(pose[:, -1, 2]), "°", "turn to the left"),
            "slip ratio": Measure(slip_ratio, "", "slide of the stance feet divided by the path"),
            "least margin": Measure(
                lambda: 1000 * motion["margin"].min(axis=1),
                "mm",
                "least static stability: distance from the centre of mass to the edge of support",
            ),
            BODY_HEIGHT: Measure(
                partial(_height, motion), "m", "mean height of the body's middle above the ground"
            ),
            **stepping_measures(
                motion["stance"],
                body.LEGS,
                motion.frame_rate,
                sides=body.SIDES,
                commanded=motion[STRIDE_FREQUENCY],
            ),
        }

    def rig(self) -> Rig:
        """Return the trunk's outline, and coxa, femur and tibia of each leg."""
        return rig(self._anatomy)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return the body's outline and legs in the world, with the resting plane on the ground.

        A foot touches the ground if it is within 2 mm of it in the frame; the channel `stance`
        considers the middle of the interval between two frames.
        """
        from gaitsim_spider.kinematics import leg_points
        from gaitsim_spider.walking import STANCE_TOLERANCE

        if self.evolve:
            own, _ = self.embody(motion["dimensions"][individual])
            return own.skeleton(motion, individual)
        anatomy = self._anatomy
        points = leg_points(motion["joint_positions"][individual], anatomy.sizes)
        points[:, anatomy.lost, 1:] = points[:, anatomy.lost, :1]
        frames = len(points)
        parts = (
            np.broadcast_to(body.OUTLINE, (frames, 4, 2, 3)),
            np.stack([points[:, :, :-1], points[:, :, 1:]], axis=3),
            motion["centre_of_mass"][individual].astype(float),
        )
        world = self._on_ground(
            np.concatenate([part.reshape(frames, -1, 3) for part in parts], axis=1),
            motion,
            individual,
        )
        segments = world[:, :-1].reshape(frames, -1, 2, 3)
        feet = segments[:, 4:].reshape(frames, 8, 3, 2, 3)[:, :, 2, 1]
        down = feet[..., 2] < body.FOOT_RADIUS + STANCE_TOLERANCE
        names = np.array([*body.OUTLINE_NAMES, *body.JOINTS])
        drawn = np.repeat([True, *~anatomy.lost], [4, *[3] * 8])
        level = Skeleton(
            segments=segments[:, drawn],
            names=tuple(names[drawn].tolist()),
            frame_rate=motion.frame_rate,
            contacts=feet,
            touching=down & ~anatomy.lost,
            contact_names=body.LEGS,
            centre=world[:, -1],
            damaged=anatomy.damaged,
        )
        return place_on_slope(level, self.world)

    def _on_ground(self, points: Array, motion: Motion, individual: int) -> Array:
        """Place points of the body, (frames, points, 3) m, in the world, tilted as it rests.

        The body leans about the point of the resting plane under its middle, which follows the
        pose, so that the feet on the ground stay in place while it leans.
        """
        from gaitsim_spider.intervals import BLOCK
        from gaitsim_spider.walking import rest

        angles = time_last(motion["joint_positions"][individual : individual + 1])
        x, y, yaw = motion["pose"][individual].T.astype(np.float64)
        down, normals = downward(self.world), np.empty((len(points), 3))
        lean = down[0] / -down[2], down[1] / -down[2]
        rest(angles, self._anatomy.legs, lean, yaw, np.zeros(1, BLOCK), normals)
        nx, ny, nz = normals.T
        heights = (normals[:, None] * points[:, :-1]).sum(axis=2).min(axis=1)
        under = np.stack([0 * nz, 0 * nz, heights / nz], axis=-1)
        upright = np.stack([1 + nz, ny, -nx, 0 * nz], axis=-1)  # the shortest way
        turn = product(turn_about(np.array([0.0, 0.0, 1.0]), yaw), upright / norm(upright)[:, None])
        place = np.stack([x, y, np.full_like(x, body.FOOT_RADIUS)], axis=-1)
        return place[:, None] + rotated(turn[:, None], points - under[:, None])


def _height(motion: Motion) -> Array:
    """Return the mean height of the body's middle above the lowest foot, (population,) m."""
    lowest = motion["feet"][..., 2].min(axis=2)
    return np.asarray(body.FOOT_RADIUS - lowest.mean(axis=1, dtype=np.float64))


def _motion(
    commands: Angles, angles: Angles, legs: LegData, down: Array, frequency: Callable[[], Array]
) -> Motion:
    """Return the motion of joints; feet, contact and travel are computed on first use.

    Args:
        commands: commanded angles, (population, 24, frames) rad.
        angles: positions of the joints, (population, 24, frames) rad.
        legs: data of the legs.
        down: direction of gravity relative to the ground, (3,).
        frequency: returns the stride frequency of the commands, (population,) Hz; 0 if unknown.
    """
    population, _, frames = angles.shape

    def place() -> dict[str, Array]:
        from gaitsim_spider.kinematics import place_feet

        feet = np.empty((population, 3, 8, frames), dtype=np.float32)
        centre = np.empty((population, 3, frames), dtype=np.float32)
        place_feet(angles, legs, feet, centre)
        return {"feet": time_second(feet), "centre_of_mass": time_second(centre)}

    def travel() -> dict[str, Array]:
        from gaitsim_spider.intervals import BLOCK, whole_blocks
        from gaitsim_spider.walking import walk

        feet = np.zeros((1, 3, 8, whole_blocks(frames)), dtype=np.float32)
        centre = np.zeros((1, 3, whole_blocks(frames)), dtype=np.float32)
        pose = np.empty((population, 3, frames), dtype=np.float32)
        stance = np.empty((population, 8, frames), dtype=np.bool_)
        slip, margin, slope = np.empty((3, population, frames), dtype=np.float32)
        blocks = np.zeros(1, BLOCK)
        level = down[0] == down[1] == 0
        lean = None if level else (down[0] / -down[2], down[1] / -down[2])
        walk(angles, legs, lean, feet, centre, blocks, pose, stance, slip, margin, slope)
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
            (STRIDE_FREQUENCY,): lambda: {STRIDE_FREQUENCY: frequency()},
        },
    )
