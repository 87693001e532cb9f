"""A fly that users steer, with one controller for each command, and a course.

The fly follows a single course. A new command changes the motion of the course and the network in
control, both within `BLEND` seconds. All networks get the same inputs, relative to this course, and
the mean of their outputs, weighted by their shares, commands the wings. Neither the inputs of the
networks nor the commands of the wings therefore jump.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin import Command, GaitsimError, Genomes, Motion, Steered
from gaitsim_fly import course, flight
from gaitsim_fly.control import command, fill_inputs, wing_commands
from gaitsim_fly.course import CLIMB, COURSE, SPEED, TURN, X, Y, Z, advance
from gaitsim_fly.flight import ALIVE, LANES, STATE, WING_SPEED, WINGS, Buffer, step
from gaitsim_fly.motion import flight_motion
from gaitsim_fly.options import BODY_INPUTS, FlyOptions


@njit(cache=True, error_model="numpy")
def _hand_over(shares: NDArray[np.float64], to: int, part: float) -> None:
    """Raise one share by `part`, at most to 1; scale the others so that the sum stays 1."""
    before = shares[to]
    if before < 1.0:
        after = min(1.0, before + part)
        for k in range(len(shares)):
            shares[k] *= (1.0 - after) / (1.0 - before)
        shares[to] = after


@njit(cache=True, error_model="numpy")
def _mean(shares: NDArray[np.float64], values: Any) -> Any:
    """Return the mean of the controllers' values, weighted by their shares."""
    total = 0.0
    for k in range(len(shares)):
        total += shares[k] * values[k]
    return total


@njit(cache=True, error_model="numpy")
def _hold(course: NDArray[np.float64], b: Buffer, leash: float) -> None:
    """Pull the course to within `leash` of the fly, horizontally and vertically."""
    x, y, z = course[X] - b[X, 0], course[Y] - b[Y, 0], course[Z] - b[Z, 0]
    away = np.sqrt(x * x + y * y)
    if away > leash:
        course[X], course[Y] = b[X, 0] + x * (leash / away), b[Y, 0] + y * (leash / away)
    course[Z] = b[Z, 0] + min(max(z, -leash), leash)


@njit(nogil=True, cache=True, error_model="numpy")
def steer(
    commanded: int,
    weights: Buffer,
    layers: NDArray[np.int64],
    code: int,
    limits: NDArray[np.float64],
    dt: float,
    steps: int,
    c: NDArray[np.float64],
    speeds: NDArray[np.float64],
    part: float,
    leash: float,
    b: Buffer,
    course: NDArray[np.float64],
    shares: NDArray[np.float64],
    states: NDArray[np.float64],
    angles: NDArray[np.float64],
    courses: NDArray[np.float64],
    blends: NDArray[np.float64],
) -> Any:
    """Simulate one fly under a command; its lanes differ only in their networks.

    Args:
        commanded: index of the command in force.
        weights: weights of the networks, (genes, LANES); lane i holds the network of command
            i modulo commands.
        layers: units of each layer, inputs first.
        code: activation of the hidden layers; the outputs always use tanh.
        limits: limits of flap, pitch and sweep, (3,) rad.
        dt: time step, s.
        steps: time steps per frame.
        c: constants; see `flight`.
        speeds: speeds of the course under each command, (commands, 3); see `course`.
        part: increase of the commanded network's share in each frame.
        leash: largest distance of the course from the fly, m.
        b: state of the fly, the same in all lanes, (BUFFER, LANES); advanced in place.
        course: course of the fly, (COURSE,); advanced in place.
        shares: weights of the networks' outputs, (commands,), with sum 1; advanced in place.
        states: output, (frames, STATE): state at the end of each frame.
        angles: output, (frames, 6): wing angles, rad.
        courses: output, (frames, COURSE): course after each frame.
        blends: output, (frames, commands): shares after each frame.

    Returns:
        The number of stable frames.
    """
    frames, commands = len(states), len(shares)
    inputs = np.empty((layers[0], LANES))
    outputs = np.empty((layers[0] - BODY_INPUTS, LANES))
    g = np.empty((COURSE, LANES))
    no_errors = np.zeros(6)  # no constant errors of the wings
    interval = steps * dt
    lasted = 0
    for frame in range(frames):
        _hand_over(shares, commanded, part)
        for k, row in enumerate((SPEED, CLIMB, TURN)):
            course[row] = _mean(shares, speeds[:, k])
        for k in range(COURSE):
            g[k] = course[k]
        fill_inputs(b, g, limits, inputs, c)
        wing_commands(weights, layers, code, inputs, outputs)
        for output in range(len(outputs)):
            outputs[output] = _mean(shares, outputs[output, :commands])
        command(b, outputs, limits, no_errors, interval, c[WING_SPEED])
        step(b, dt, steps, c)
        advance(course, interval)
        _hold(course, b, leash)
        for k in range(STATE):
            states[frame, k] = b[k, 0]
        for k in range(6):
            angles[frame, k] = b[WINGS + k, 0]
        courses[frame], blends[frame] = course, shares
        if b[ALIVE, 0] > 0.0:
            lasted += 1
    return lasted


BLEND = 0.2  # s, time in which control passes from one controller to another
LEASH = 1.0  # m, largest horizontal and vertical distance of the course from the fly
START = 2.0  # m, altitude of the start above the ground, z = 0

COMMANDS = (
    Command("hover", "down", "hover in place"),
    Command("climb", "space", "climb"),
    Command("left", "left", "turn left in place"),
    Command("right", "right", "turn right in place"),
    Command("forward", "up", "fly forward"),
)
NAMES = tuple(command.name for command in COMMANDS)


class SteeredFly(Steered):
    """A fly that follows commands; it starts at rest, level and 2 m above the ground.

    Args:
        fly: body and network.
        controllers: genome (genes,) of each command.
    """

    def __init__(self, fly: FlyOptions, controllers: Mapping[str, Genomes]) -> None:
        self.fly = fly
        self.frame_rate = 1 / fly.control_step
        genomes = controller_genomes(fly, controllers)
        lanes = np.arange(flight.LANES) % len(NAMES)  # the controller of each lane
        self._weights = np.ascontiguousarray(genomes[lanes].T)
        self._rates = np.array([fly.course_speeds(name) for name in NAMES])
        self._shares = np.array([1.0] + [0.0] * (len(NAMES) - 1))
        self._course = course.initial_courses(np.zeros(1), self._rates[0])[0]
        self._course[course.Z] = START
        self._buffer = np.zeros((flight.BUFFER, flight.LANES))
        self._buffer[flight.POSITION + 2] = START
        self._buffer[[flight.ROTATION, flight.ALIVE]] = 1.0
        self._command = 0
        self._mechanics = fly.mechanics(fly.world)
        self._control_arguments = fly.control_arguments(self._mechanics)
        self._flown = 0

    def give(self, command: str) -> None:
        """Put the network of a command in control, until the next command."""
        if command not in NAMES:
            raise GaitsimError(f"unknown command {command!r}", allowed=", ".join(NAMES))
        self._command = NAMES.index(command)

    def advance(self, frames: int) -> Motion:
        """Simulate `frames` frames, which are control steps of the network."""
        if frames < 1:
            raise GaitsimError(f"cannot advance by {frames} frames", allowed="1 or more")
        states = np.empty((frames, flight.STATE))
        angles = np.empty((frames, 6))
        courses = np.empty((frames, course.COURSE))
        shares = np.empty((frames, len(NAMES)))
        lasted = steer(
            self._command,
            self._weights,
            *self._control_arguments,
            self._rates,
            self.fly.control_step / BLEND,
            LEASH,
            self._buffer,
            self._course,
            self._shares,
            states,
            angles,
            courses,
            shares,
        )
        failures = {}
        self._flown += frames
        if lasted < frames:
            seconds = (self._flown - frames + lasted) * self.fly.control_step
            failures[0] = f"the flight became unstable within {seconds:.4g} s"
        return flight_motion(
            self.frame_rate,
            states[None, :, None],
            angles[None, :, None],
            courses[:, None],
            self._mechanics.inertia,
            failures,
            shares=shares[None],
        )


def controller_genomes(fly: FlyOptions, controllers: Mapping[str, Genomes]) -> Genomes:
    """Return the genomes of the controllers in the order of the commands, (commands, genes)."""
    if fly.planar:
        raise GaitsimError(
            "a fly with symmetric wings cannot turn, so it cannot be steered",
            key="organism.wings",
            allowed='organism.wings = "mirrored" or "asymmetric"',
        )
    genes = fly.genome_space().genes
    for name in NAMES:
        if name not in controllers:
            raise GaitsimError(f"no controller for the command {name!r}", allowed=", ".join(NAMES))
        shape = np.shape(controllers[name])
        if shape != (genes,):
            raise GaitsimError(
                f"the controller {name!r} has shape {shape}, expected ({genes},)",
                allowed=f"genomes of networks of {'-'.join(map(str, fly.layers))} units",
            )
    return np.array([controllers[name] for name in NAMES], dtype=np.float64)
