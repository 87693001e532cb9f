"""The fly: a rigid body with two wings, controlled by a neural network."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import (
    Array,
    Channel,
    Command,
    Genomes,
    Measure,
    Motion,
    RealSpace,
    Skeleton,
    Steered,
    SteeringPage,
)
from gaitsim.network import ACTIVATION_CODES, gene_labels
from gaitsim_fly.conditions import push, wing_offsets
from gaitsim_fly.measures import measures
from gaitsim_fly.mechanics import Mechanics
from gaitsim_fly.motion import flight_motion
from gaitsim_fly.options import COURSES, FlyOptions
from gaitsim_fly.skeleton import skeleton
from gaitsim_fly.starts import headings, starts

ControlArguments = tuple[
    NDArray[np.int64], int, NDArray[np.float64], float, int, NDArray[np.float64]
]

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

    def genome_space(self) -> RealSpace:
        """Return the space of weights and biases: W1 row by row, b1, W2, b2 …"""
        labels = gene_labels(self.layers)
        limit = np.full(len(labels), self.weight_limit)
        return RealSpace(-limit, limit, labels, np.full(len(labels), self.weight_sigma))

    def starts(self) -> NDArray[np.float64]:
        """Return the state at the start of each trial, (trials, STATE); see `flight`."""
        return starts(
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
            np.ascontiguousarray(genomes, dtype=np.float64),
            self.starts(),
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

    def control_arguments(self, own: Mechanics) -> ControlArguments:
        """Return the arguments of the compiled flight that describe the network and the mechanics.

        Returns:
            Units of each layer; the activation's code; limits of flap, pitch and sweep, (3,) rad;
            the time step, s; time steps between commands; the constants (see `gaitsim_fly.flight`).
        """
        nominal = round(self.control_step / self.dt)
        # The time step of the options may be unstable in a denser world.
        steps = max(nominal, math.ceil(self.control_step / own.stable_step))
        return (
            np.array(self.layers),
            ACTIVATION_CODES[self.activation],
            np.radians([self.flap_limit, self.pitch_limit, self.sweep_limit]),
            self.dt if steps == nominal else self.control_step / steps,
            steps,
            self._constants(own),
        )

    def _constants(self, own: Mechanics) -> NDArray[np.float64]:
        from gaitsim_fly import flight

        c = np.empty(flight.CONSTANTS)
        own.fill(c)
        c[flight.SPEED_LIMIT] = flight.FASTEST
        c[flight.TURN_LIMIT] = flight.LARGEST_TURN
        c[flight.POSITION_SCALE] = self.position_scale
        c[flight.VELOCITY_SCALE] = self.velocity_scale
        c[flight.SPIN_SCALE] = self.spin_scale
        return c

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
        from gaitsim_fly.controllers import trained_networks

        found = trained_networks()
        fit = self.wings == "mirrored" and self.layers == found.layers
        return found.genomes if fit and self.activation == "tanh" else {}

    def steer(self, controllers: Mapping[str, Genomes]) -> Steered:
        """Return a steered fly, at rest and level, 2 m above the ground, z = 0."""
        from gaitsim_fly.steering import SteeredFly

        return SteeredFly(self, controllers)

    def steering_page(self, controllers: Mapping[str, Genomes]) -> SteeringPage:
        """Return the script and data of a page that simulates the fly exactly as Python does."""
        from gaitsim_fly.page import page

        return page(self, controllers)
