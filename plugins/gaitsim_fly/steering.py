"""A fly that users steer, with one controller for each command, and a course.

The fly follows a single course. A new command changes the motion of the course and the network in
control, both within `BLEND` seconds. All networks get the same inputs, relative to this course, and
the mean of their outputs, weighted by their shares, commands the wings. Neither the inputs of the
networks nor the commands of the wings therefore jump.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.contracts import Command, Genomes, Motion, Steered
from gaitsim.errors import GaitsimError
from gaitsim_fly import course, flight
from gaitsim_fly.motion import flight_motion
from gaitsim_fly.steps import steer

if TYPE_CHECKING:
    from gaitsim_fly.organism import Fly

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

    def __init__(self, fly: "Fly", controllers: Mapping[str, Genomes]) -> None:
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
        self._mechanics = fly.mechanics(fly.world)
        self._control_arguments = fly.control_arguments(self._mechanics)
        self._flown = 0

    def advance(self, command: str, frames: int) -> Motion:
        """Simulate `frames` frames, which are control steps of the network, under a command."""
        if command not in NAMES:
            raise GaitsimError(f"unknown command {command!r}", allowed=", ".join(NAMES))
        if frames < 1:
            raise GaitsimError(f"cannot advance by {frames} frames", allowed="1 or more")
        states = np.empty((frames, flight.STATE))
        angles = np.empty((frames, 6))
        courses = np.empty((frames, course.COURSE))
        shares = np.empty((frames, len(NAMES)))
        lasted = steer(
            NAMES.index(command),
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


def controller_genomes(fly: "Fly", controllers: Mapping[str, Genomes]) -> Genomes:
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
