"""Steering a body in real time: the bodies with commands, their controllers, and the simulation."""

from collections import deque
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim import registry
from gaitsim.choices import STEERING_PRESET
from gaitsim.contracts import Command, Genomes, Motion, Organism, Skeleton, Steered
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.gait.travel import heading, size, trunk
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.runs.compatibility import expected_genomes, genome_mismatch
from gaitsim.runs.creation import find_individual

RECENT = 3.0  # seconds of recent motion kept in full
PATH_RATE = 10.0  # rate at which points of the path are kept, Hz
MOST_PATH_POINTS = 6000  # points of the path, at most
MOST_CATCH_UP = 1.0  # seconds simulated at once, at most; a longer gap counts as a pause
SPEED_WINDOW = 0.25  # seconds over which speeds are averaged
SHARES = "shares"  # channel of a steered motion, (1, frames, commands)


def commands_of(experiment: Experiment) -> tuple[Command, ...]:
    """Return the commands of an experiment's body; () for a body without commands."""
    entry = experiment.entries["organism"]
    with plugin_errors(entry, "naming its commands"):
        commands = tuple(experiment.organism.commands())
    if not all(isinstance(command, Command) for command in commands):
        raise contract_error(
            entry, f"returned {commands!r:.200} from commands()", "objects of the class Command"
        )
    for what in ("key", "name"):
        if len({getattr(command, what) for command in commands}) < len(commands):
            raise contract_error(
                entry,
                f"has two commands with the same {what}",
                f"a different {what} for each command",
            )
    return commands


def offered_commands(experiment: Experiment) -> tuple[Command, ...]:
    """Return the commands of an experiment's body; () if it has none or fails."""
    try:
        return commands_of(experiment)
    except GaitsimError:
        return ()


def steered_bodies() -> list[str]:
    """Return the names of installed bodies with commands."""
    found, _ = registry.scan("organism")
    return sorted(
        name
        for name, kind in found.items()
        if issubclass(kind, Organism) and kind.commands is not Organism.commands
    )


def controllers_of(experiment: Experiment, replaced: Mapping[str, str]) -> dict[str, Genomes]:
    """Return the genome of the controller of each command, of shape (genes,), by command name.

    Args:
        experiment: experiment of the body.
        replaced: individuals, as accepted by `--from`, by command name; other commands use the
            controllers of the body's package.
    """
    entry = experiment.entries["organism"]
    names = [command.name for command in commands_of(experiment)]
    if not names:
        bodies = steered_bodies()
        options = " with these options" if entry.name in bodies else ""
        raise GaitsimError(
            f"the body {entry.name!r}{options} cannot be steered: it has no steering commands",
            where=f"experiment {experiment.name}",
            allowed=f"a body with steering commands: {', '.join(bodies) or 'none is installed'}",
            remedy=f"use the preset {STEERING_PRESET!r}",
        )
    for name in replaced:
        if name not in names:
            raise GaitsimError(
                f"the body {entry.name!r} has no steering command {name!r}",
                where="--controller",
                allowed=", ".join(names),
            )
    with plugin_errors(entry, "reading its controllers"):
        found = dict(experiment.organism.controllers())
    for name, reference in replaced.items():
        found[name] = _controller_genome(experiment, reference, f"--controller {name}={reference}")
    missing = [name for name in names if name not in found]
    if missing:
        raise GaitsimError(
            f"the body {entry.name!r} with these options has no controller for the command "
            f"{missing[0]!r}",
            where=f"experiment {experiment.name}",
            allowed="a controller for each command: " + ", ".join(names),
            remedy=f"add --controller {missing[0]}=RUN with a run that trained this controller",
        )
    return {name: found[name] for name in names}


def _controller_genome(experiment: Experiment, reference: str, where: str) -> Genomes:
    """Return the genome, (genes,), of a saved individual after checking that it fits the body."""
    try:
        saved = find_individual(reference)
    except GaitsimError as error:
        error.where = where if error.where in ("", "--from") else error.where
        raise
    wrong = genome_mismatch(experiment, saved.genome[None], saved.experiment, "the genome")
    if wrong:
        raise GaitsimError(
            f"{wrong}; it cannot control this body",
            where=where,
            allowed=expected_genomes(experiment),
            remedy="choose an individual of the same body, with the same options for its genome",
        )
    return saved.genome


def default_drive() -> "Drive":
    """Return the body of the default preset at its start, with the controllers of its package."""
    return create_drive(load_experiment(STEERING_PRESET), {})


def create_drive(experiment: Experiment, replaced: Mapping[str, str]) -> "Drive":
    """Return an experiment's body at its start, with the controllers from `controllers_of`."""
    return Drive(experiment, controllers_of(experiment, replaced))


class Drive:
    """A steered body, simulated from its start until it crashes.

    Args:
        experiment: experiment of the body.
        controllers: genome of the controller of each command, of shape (genes,), by name.

    Attributes:
        commands: commands of the body; the first one is active at the start.
        command: active command.
        size: longest diagonal of the box around the body, m.
        ending: reason why the motion ended; '' until then.
        shares: weight of each controller in the movement, (commands,), with the sum 1.
    """

    def __init__(self, experiment: Experiment, controllers: Mapping[str, Genomes]) -> None:
        self._organism, self._entry = experiment.organism, experiment.entries["organism"]
        self._controllers = controllers
        self.commands = commands_of(experiment)
        self.restart()

    def restart(self) -> None:
        """Restart the simulation."""
        with plugin_errors(self._entry, "preparing to be steered"):
            steered: object = self._organism.steer(self._controllers)
        if not isinstance(steered, Steered):
            raise contract_error(
                self._entry, f"returned a {type(steered).__name__} from steer()", "a Steered"
            )
        with plugin_errors(self._entry, "giving its frame rate"):
            self.frame_rate = float(steered.frame_rate)
        if not 0 < self.frame_rate < np.inf:
            raise contract_error(
                self._entry, f"has the frame rate {self.frame_rate:g}", "a finite one above 0 Hz"
            )
        self._steered = steered
        self.command = self.commands[0]
        self.ending = ""
        self.shares = np.eye(len(self.commands))[0]
        self._frames, self._lag = 0, 0.0
        self._latest: deque[NDArray[np.float64]] = deque(maxlen=int(RECENT * self.frame_rate) + 1)
        self._centres: deque[NDArray[np.float64]] = deque(maxlen=self._latest.maxlen)
        self._path: deque[NDArray[np.float64]] = deque(maxlen=MOST_PATH_POINTS)
        self._first: Skeleton | None = None
        self._simulate(1)

    @property
    def seconds(self) -> float:
        """Simulated time in seconds."""
        return self._frames / self.frame_rate

    def choose(self, name: str) -> None:
        """Activate the command with this name from the next frame."""
        self.command = next(command for command in self.commands if command.name == name)

    def advance_to(self, seconds: float) -> None:
        """Simulate up to a time on a clock that started with the simulation.

        A gap of more than a second counts as a pause of the whole program; the excess is skipped.

        Args:
            seconds: time on that clock.
        """
        behind = int((seconds - self._lag) * self.frame_rate) - self._frames
        most = int(MOST_CATCH_UP * self.frame_rate)
        if behind > most:
            self._lag += (behind - most) / self.frame_rate
            behind = most
        if behind > 0 and not self.ending:
            self._simulate(behind)

    def _simulate(self, frames: int) -> None:
        with plugin_errors(self._entry, "being steered"):
            motion = self._steered.advance(self.command.name, frames)
            skeleton = self._organism.skeleton(motion, 0)
        self._check(motion, skeleton, frames)
        if self._first is None:
            self._first, self.size = skeleton, size(skeleton)
        flown = _until_ground(skeleton)
        every = max(round(self.frame_rate / PATH_RATE), 1)
        for frame in range(flown):
            self._latest.append(np.asarray(skeleton.segments[frame], dtype=np.float64))
            self._centres.append(np.asarray(skeleton.path[frame], dtype=np.float64))
            if (self._frames + frame) % every == 0:
                self._path.append(self._centres[-1])
        self._frames += flown
        if SHARES in motion and flown:
            self.shares = np.asarray(motion[SHARES][0, flown - 1], dtype=np.float64)
        elif SHARES not in motion:
            self.shares = np.eye(len(self.commands))[self.commands.index(self.command)]
        if motion.failures:
            self.ending = f"It ended after {self.seconds:.1f} s: {motion.failures[0]}."
        elif flown < frames:
            self.ending = f"It hit the ground after {self.seconds:.1f} s."

    def _check(self, motion: Motion, skeleton: Skeleton, frames: int) -> None:
        """Check that the frames fulfil the contract of a steered body."""
        wrong = ""
        if len(skeleton.segments) != frames:
            wrong = f"advanced {len(skeleton.segments)} frames instead of {frames}"
        elif not (np.isfinite(skeleton.segments).all() and np.isfinite(skeleton.path).all()):
            wrong = "advanced to positions that are not finite"
        elif SHARES in motion and motion[SHARES].shape != (1, frames, len(self.commands)):
            wrong = f"returned shares of shape {motion[SHARES].shape}"
        if wrong:
            allowed = (
                "finite positions in each requested frame; shares of shape (1, frames, commands)"
            )
            raise contract_error(self._entry, wrong, allowed)

    @property
    def skeleton(self) -> Skeleton:
        """The body over the last three seconds; the last frame is the current one."""
        assert self._first is not None, "a frame is simulated at the start"
        return Skeleton(
            np.stack(self._latest),
            self._first.names,
            self.frame_rate,
            centre=np.stack(self._centres),
        )

    @property
    def path(self) -> NDArray[np.float64]:
        """The path of the body at ten points per second, (points, 3) m, the current point last."""
        return np.stack([*self._path, self._centres[-1]])

    @property
    def altitude(self) -> float:
        """Height of the body's centre above the ground, m."""
        return float(self._centres[-1][2])

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Mean velocity over the last quarter of a second, (3,) m/s."""
        frames = min(int(SPEED_WINDOW * self.frame_rate), len(self._centres) - 1)
        if not frames:
            return np.zeros(3)
        moved = self._centres[-1] - self._centres[-1 - frames]
        return np.asarray(moved * self.frame_rate / frames, dtype=np.float64)

    @property
    def turned(self) -> float | None:
        """The turn to the left since the start, radians; None for a body without a heading."""
        assert self._first is not None, "a frame is simulated at the start"
        both = np.stack([self._first.segments[0], self._latest[-1]])
        found = heading(trunk(Skeleton(both, self._first.names, self.frame_rate)))
        return None if found is None else float((found[-1] + np.pi) % (2 * np.pi) - np.pi)


def _until_ground(skeleton: Skeleton) -> int:
    """Return the number of frames before a body without feet hits the ground, or of all frames."""
    if skeleton.contacts is not None:
        return len(skeleton.segments)
    below = np.flatnonzero(skeleton.segments[..., 2].min(axis=(1, 2)) < 0)
    return int(below[0]) if len(below) else len(skeleton.segments)
