"""The fly: a rigid body with two wings, controlled by a neural network."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    Array,
    Channel,
    Command,
    Genomes,
    Measure,
    Motion,
    RealSpace,
    Skeleton,
    Steered,
)
from gaitsim.plugin.toolkit import Network, cos, gene_labels, norm, sin, uniform
from gaitsim_fly.flight import MOMENTUM, POSITION, ROTATION, STATE, VELOCITY
from gaitsim_fly.motion import flight_motion, measures, skeleton
from gaitsim_fly.options import BODY_INPUTS, COURSES, FlyOptions, push, wing_offsets


def start_states(
    trials: int,
    seed: int,
    inertia: NDArray[np.float64],
    *,
    offset: float,
    tilt: float,
    headings: NDArray[np.float64],
    speed: float,
    spin: float,
    planar: bool,
) -> NDArray[np.float64]:
    """Return the state at the start of each trial, (trials, STATE); the first is level, at rest.

    Args:
        trials: number of trials.
        seed: seed of the other states, which are drawn uniformly along each axis.
        inertia: moments of inertia, (3,) kg·m².
        offset: largest distance from the origin along each axis, m.
        tilt: largest component of the rotation vector, rad.
        headings: headings of the trials, (trials,) rad.
        speed: largest speed along each axis, m/s.
        spin: largest angular speed about each axis, rad/s.
        planar: whether to draw only symmetric starts, as wings with equal commands cannot correct
            asymmetric ones.
    """
    states = np.zeros((trials, STATE))
    states[:, ROTATION] = 1.0
    draws = uniform(np.random.default_rng(seed), -1, 1, (trials - 1, 4, 3))
    if planar:
        draws[:, (0, 2), 1] = 0.0  # sideways position and velocity
        draws[:, 1::2, ::2] = 0.0  # roll and yaw
    turn = tilt * draws[:, 1]
    half = norm(turn)[:, None] / 2
    states[1:, POSITION : POSITION + 3] = offset * draws[:, 0]
    states[1:, ROTATION : ROTATION + 1] = cos(half)
    # sin(half) / half, which tends to 1
    ratio = np.where(half > 0, sin(half), 1.0) / np.where(half > 0, half, 1.0)
    states[1:, ROTATION + 1 : ROTATION + 4] = turn / 2 * ratio
    states[:, ROTATION : ROTATION + 4] = _turn_about_vertical(
        states[:, ROTATION : ROTATION + 4], headings / 2
    )
    states[1:, VELOCITY : VELOCITY + 3] = speed * draws[:, 2]
    momentum = inertia * (spin * draws[:, 3])  # in the frame of the body
    states[1:, MOMENTUM : MOMENTUM + 3] = _rotate(states[1:, ROTATION : ROTATION + 4], momentum)
    return states


def headings(trials: int, seed: int, largest: float) -> NDArray[np.float64]:
    """Return the heading of each trial, (trials,) rad: 0 for the first, random for the others."""
    drawn = uniform(np.random.default_rng([seed, 1]), -1, 1, trials - 1)
    return np.concatenate([[0.0], largest * drawn])


def _turn_about_vertical(
    quaternions: NDArray[np.float64], half: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Turn attitudes about the vertical by twice the angles `half`, (trials,) rad."""
    w, x, y, z = quaternions.T
    c, s = cos(half), sin(half)
    return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=1)


def _rotate(quaternions: NDArray[np.float64], vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotate vectors, (trials, 3), by unit quaternions, (trials, 4)."""
    w, u = quaternions[:, :1], quaternions[:, 1:]
    cross = np.cross(u, vectors)
    result: NDArray[np.float64] = vectors + 2 * (w * cross + np.cross(u, cross))
    return result


@dataclass(frozen=True, eq=False)
class TrainedNetworks:
    """Trained networks.

    Attributes:
        layers: units of each layer, inputs first.
        genomes: genomes (genes,) by command.
        experiments: experiments that trained the networks, as TOML, by command.
    """

    layers: tuple[int, ...]
    genomes: dict[str, Genomes]
    experiments: dict[str, str]


@cache
def trained_networks() -> TrainedNetworks:
    """Return the networks in `controllers.npz`."""
    with (
        as_file(files("gaitsim_fly") / "controllers.npz") as path,
        np.load(path, allow_pickle=False) as stored,
    ):
        names = stored["commands"].tolist()
        genomes = {name: stored[name] for name in names}
        for genome in genomes.values():
            genome.flags.writeable = False
        experiments = {name: str(stored[f"{name} experiment"]) for name in names}
        return TrainedNetworks(tuple(stored["layers"].tolist()), genomes, experiments)


def wing_beat(layers: Sequence[int]) -> NDArray[np.float64]:
    """Return a network that beats the wings and ignores the body, as a genome (genes,).

    Flap and pitch switch each other, as in a relaxation oscillator. While the pitch is above a
    threshold, the wing flaps down, otherwise up; while the flap is above another threshold, the
    pitch rises, otherwise it falls. The limited speed of the wings delays each, so that the wing is
    flat in the middle of its stroke down, and stands on edge on its way up.

    Args:
        layers: units of each layer, at least two in each of one or more hidden layers.
    """
    weights = [np.zeros((outputs, inputs)) for inputs, outputs in pairwise(layers)]
    biases = [np.zeros(outputs) for outputs in layers[1:]]
    flap, pitch = BODY_INPUTS, BODY_INPUTS + 1
    weights[0][0, flap] = weights[0][1, pitch] = 3.0
    biases[0][:2] = -0.5, 1.5
    for weight in weights[1:-1]:
        weight[0, 0] = weight[1, 1] = 3.0
    for wing in range(0, layers[-1], 3):
        weights[-1][wing, 1], weights[-1][wing + 1, 0] = -4.0, 4.0
        biases[-1][wing] = -2.0
    return Network(tuple(weights), tuple(biases)).genes


TRIALS = ("frames", "trials")
XYZ = ("x", "y", "z")
WINGS = ("left flap", "left pitch", "left sweep", "right flap", "right pitch", "right sweep")


class Fly(FlyOptions):
    """A cuboid with two triangular wings in air; a neural network commands the wings."""

    portable: ClassVar[bool] = True
    threads: ClassVar[bool] = True
    dynamic: ClassVar[bool] = True
    channels: ClassVar[Mapping[str, Channel]] = {
        "position": Channel((*TRIALS, XYZ), "m", "centre of mass; z is up"),
        "altitude": Channel(TRIALS, "m", "z of the position"),
        "rotation": Channel((*TRIALS, ("w", "x", "y", "z")), "", "unit quaternion of the body"),
        "course": Channel(
            (*TRIALS, ("x", "y", "z", "heading")),
            ("m", "m", "m", "rad"),
            "point and heading of the course; zero without a course",
        ),
        "velocity": Channel((*TRIALS, XYZ), "m/s", "velocity in the world frame"),
        "angular_velocity": Channel((*TRIALS, XYZ), "rad/s", "angular velocity in the world frame"),
        "wing_angles": Channel((*TRIALS, WINGS), "rad", "angles of the wings"),
    }

    def starts(self) -> Mapping[str, Array]:
        """Return a wing beat made by hand; {} for networks that cannot hold it."""
        fits = len(self.hidden) > 0 and min(self.hidden) > 1 and self.activation == "tanh"
        return {"wing beat": self.genome_space().repair(wing_beat(self.layers))} if fits else {}

    def genome_space(self) -> RealSpace:
        """Return the space of weights and biases: W1 row by row, b1, W2, b2 …"""
        labels = gene_labels(self.layers)
        limit = np.full(len(labels), self.weight_limit)
        return RealSpace(-limit, limit, labels, np.full(len(labels), self.weight_sigma))

    def start_states(self) -> NDArray[np.float64]:
        """Return the state at the start of each trial, (trials, STATE); see `flight`."""
        return start_states(
            self.trials,
            self.trial_seed,
            self.mechanics(self.world).inertia,
            offset=self.start_offset,
            tilt=math.radians(self.start_tilt),
            headings=self._headings(),
            speed=self.start_speed,
            spin=self.start_spin,
            planar=self.planar,
        )

    def _headings(self) -> NDArray[np.float64]:
        return headings(self.trials, self.trial_seed, math.radians(self.start_heading))

    def _courses(self) -> NDArray[np.float64]:
        """Return the course of each trial, (trials, frames, COURSE)."""
        from gaitsim_fly import course

        headings = np.zeros(self.trials) if self.course == "none" else self._headings()
        own = self.course_speeds(self.course)
        shape = self.trials, self.frames
        speeds = np.broadcast_to(own, (*shape, 3))
        if self.course_changes and self.course != "none":
            others = np.array([self.course_speeds(name) for name in COURSES])
            mean = self.course_changes / self.control_step
            speeds = course.alternating_speeds(own, others, shape, mean, self.trial_seed)
        return course.paths(
            course.initial_courses(headings, own), np.ascontiguousarray(speeds), self.control_step
        )

    def move(self, genomes: Genomes) -> Motion:
        """Simulate every trial of every individual."""
        from gaitsim_fly import flight
        from gaitsim_fly.control import fly

        own, interval = self.mechanics(self.world), self.control_step
        population, lanes = len(genomes), len(genomes) * self.trials
        states = np.empty((lanes, self.frames, flight.STATE))
        angles = np.empty((lanes, self.frames, 6))
        lasted = np.empty(lanes, dtype=np.int64)
        courses = self._courses()
        fly(
            # Writable, as the kernel is compiled once more for the genomes of stored networks.
            np.require(genomes, np.float64, ("C", "W")),
            self.start_states(),
            courses,
            *self.control_arguments(own),
            wing_offsets(self.world, planar=self.planar),
            self.world.get("latency", 0.0) / interval,
            *push(self.world, self.frames, planar=self.planar),
            states,
            angles,
            lasted,
        )

        def by_trial(values: Array) -> Array:
            """Reshape (lanes, frames, …) to (population, frames, trials, …)."""
            return values.reshape(population, self.trials, *values.shape[1:]).swapaxes(1, 2)

        return flight_motion(
            1 / interval,
            by_trial(states),
            by_trial(angles),
            courses.swapaxes(0, 1),
            own.inertia,
            self._failures(lasted),
        )

    def _failures(self, lasted: NDArray[np.int64]) -> dict[int, str]:
        """Return the reasons why flights failed, by individual."""
        failures = {}
        for lane in np.flatnonzero(lasted < self.frames)[::-1].tolist():  # report the first trial
            individual, trial = divmod(lane, self.trials)
            failures[individual] = (
                f"the flight became unstable within {lasted[lane] * self.control_step:.4g} s"
                + (f" in trial {trial + 1}" if self.trials > 1 else "")
                + f"; try a dt below {self.dt:g} s"
            )
        return failures

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return altitudes, horizontal distance, tilt and wing beats, as means over the trials."""
        return measures(motion)

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return body and wings in the world frame, in the first trial."""
        size = (self.length, self.width, self.height)
        return skeleton(motion, individual, size, self.span, self.chord)

    def commands(self) -> tuple[Command, ...]:
        """Return hover, climb, left, right and forward; () for symmetric wings."""
        from gaitsim_fly.steering import COMMANDS

        return () if self.planar else COMMANDS

    def controllers(self) -> Mapping[str, Genomes]:
        """Return the package's trained networks, mirrored and 18-12-3, or {} if they do not fit."""
        found = trained_networks()
        fit = self.wings == "mirrored" and self.layers == found.layers
        return found.genomes if fit and self.activation == "tanh" else {}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return a steered fly, at rest and level, 2 m above the ground, z = 0."""
        from gaitsim_fly.steering import SteeredFly

        return SteeredFly(self, controllers)
