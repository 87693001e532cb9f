"""The fly under a person's command: a controller for each command, and its course.

The fly follows one course all the time. A new command changes how the course moves and which
network is in command, both within `BLEND` seconds: networks see the same fly from the same
course, and the mean of their outputs, weighted by their shares, commands the wings. So neither
what the networks see nor what the wings are told has a jump.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.contracts import Command, Genomes, Motion, Steered
from gaitsim.errors import GaitsimError
from gaitsim_fly import course, flight
from gaitsim_fly.flights import flights
from gaitsim_fly.steps import steer

if TYPE_CHECKING:
    from gaitsim_fly.organism import Fly

BLEND = 0.2  # s, from one controller wholly in command to another
LEASH = 1.0  # m, by which the fly's course is away from it at most, level and in height
START = 2.0  # m above the ground, z = 0

COMMANDS = (
    Command("hover", "down", "stay at the place"),
    Command("climb", "space", "rise"),
    Command("left", "left", "turn left at the place"),
    Command("right", "right", "turn right at the place"),
    Command("forward", "up", "fly ahead"),
)
NAMES = tuple(command.name for command in COMMANDS)


class SteeredFly(Steered):
    """A fly that follows commands from rest, level, 2 m above the ground.

    Args:
        fly: body and network.
        controllers: a genome (genes,) for each command.

    Raises:
        GaitsimError: a controller is missing or does not fit the network.
    """

    def __init__(self, fly: "Fly", controllers: Mapping[str, Genomes]) -> None:
        self.fly = fly
        self.frame_rate = 1 / fly.control_step
        genomes = fitting(fly, controllers)
        lanes = np.arange(flight.LANES) % len(NAMES)  # a lane for each controller
        self._weights = np.ascontiguousarray(genomes[lanes].T)
        self._rates = np.array([fly.course_speeds(name) for name in NAMES])
        self._shares = np.array([1.0] + [0.0] * (len(NAMES) - 1))
        self._course = course.start(np.zeros(1), self._rates[0])[0]
        self._course[course.Z] = START
        self._buffer = np.zeros((flight.BUFFER, flight.LANES))
        self._buffer[flight.POSITION + 2] = START
        self._buffer[[flight.ROTATION, flight.ALIVE]] = 1.0
        self._mechanics = fly.mechanics(fly.world)
        self._controlled = fly.controlled(self._mechanics)
        self._flown = 0

    def advance(self, command: str, frames: int) -> Motion:
        """Fly on for some frames, control steps of the network, under a command."""
        if command not in NAMES:
            raise GaitsimError(f"no command {command!r}", allowed=", ".join(NAMES))
        if frames < 1:
            raise GaitsimError(f"{frames} frames to advance", allowed="1 or more")
        states = np.empty((frames, flight.STATE))
        angles = np.empty((frames, 6))
        courses = np.empty((frames, course.COURSE))
        shares = np.empty((frames, len(NAMES)))
        lasted = steer(
            NAMES.index(command),
            self._weights,
            *self._controlled,
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
        return flights(
            self.frame_rate,
            states[None, :, None],
            angles[None, :, None],
            courses[:, None],
            self._mechanics.inertia,
            failures,
            shares=shares[None],
        )


def fitting(fly: "Fly", controllers: Mapping[str, Genomes]) -> Genomes:
    """Return the genomes in the order of the commands, (commands, genes)."""
    if fly.planar:
        raise GaitsimError(
            "a fly with symmetric wings cannot turn, so nobody can steer it",
            key="organism.wings",
            allowed='organism.wings = "asymmetric"',
        )
    genes = fly.genome_space().genes
    for name in NAMES:
        if name not in controllers:
            raise GaitsimError(f"no controller for the command {name!r}", allowed=", ".join(NAMES))
        shape = np.shape(controllers[name])
        if shape != (genes,):
            raise GaitsimError(
                f"the controller {name!r} has the shape {shape}, expected ({genes},)",
                allowed=f"genomes of networks of {'-'.join(map(str, fly.layers))} units",
            )
    return np.array([controllers[name] for name in NAMES], dtype=np.float64)
