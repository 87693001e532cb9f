"""Steering a body in real time: the bodies with commands, their controllers, and the simulation."""

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim import registry
from gaitsim.contracts import Command, Genomes, Motion, Organism, Skeleton, Steered
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import (
    WORLD,
    Experiment,
    Overrides,
    parse_experiment,
    with_overrides,
)
from gaitsim.experiment.model import (
    NO_REALITY,
    ONE_ISLAND,
    UNCONSTRAINED,
    Evolution,
)
from gaitsim.gait.changed import has_rhythm_on_twin, rhythm_on_twin, with_changed_body
from gaitsim.gait.travel import heading, size, trunk
from gaitsim.individual import Individual
from gaitsim.registry import STEER, contract_error, entries, plugin_errors
from gaitsim.storage.compatibility import expected_genomes, genome_mismatch
from gaitsim.storage.creation import create_run, find_individual
from gaitsim.storage.files.checkpoint import Start
from gaitsim.storage.writer import RunWriter

RECENT = 3.0  # seconds of recent motion kept in full
PATH_RATE = 10.0  # rate at which points of the path are kept, Hz
MOST_PATH_POINTS = 6000  # points of the path, at most
MOST_CATCH_UP = 1.0  # seconds simulated at once, at most; a longer gap counts as a pause
SPEED_WINDOW = 0.25  # seconds over which speeds are averaged
RECORDED = "recorded drive"  # for messages
DRIVE = "drive"  # option of bodies that repeat drives
LINGER = 2.0  # s, least time after the last command of a drive
DRIVEN = "-drive"  # end of the names of recorded drives
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


def own_controllers(experiment: Experiment) -> tuple[Command, ...]:
    """Return the commands with a controller of the same name; () if none, or if the body fails."""
    try:
        commands = commands_of(experiment)
        with plugin_errors(experiment.entries["organism"], "naming its controllers"):
            names = tuple(experiment.organism.controller_names())
    except GaitsimError:
        return ()
    return tuple(one for one in commands if one.name in names)


def steered_bodies() -> list[str]:
    """Return the names of installed bodies with commands."""
    found, _ = registry.scan("organism")
    return sorted(
        name
        for name, kind in found.items()
        if issubclass(kind, Organism) and kind.commands is not Organism.commands
    )


def controllers_of(experiment: Experiment, replaced: Mapping[str, str]) -> dict[str, Genomes]:
    """Return the genomes of the controllers, each of shape (genes,), by name.

    Args:
        experiment: experiment of the body.
        replaced: individuals, as accepted by `--from`, by the name of the controller that they
            replace; other controllers are those of the body's package.
    """
    entry, names = experiment.entries["organism"], _controller_names(experiment)
    for name in replaced:
        if name not in names:
            raise GaitsimError(
                f"the body {entry.name!r} has no controller {name!r}",
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
            f"the body {entry.name!r} with these options has no controller {missing[0]!r}",
            where=f"experiment {experiment.name}",
            allowed="a controller for each of: " + ", ".join(names),
            remedy=f"add --controller {missing[0]}=RUN with a run that trained this controller",
        )
    return {name: found[name] for name in names}


def _controller_names(experiment: Experiment) -> tuple[str, ...]:
    """Return the names of the controllers of an experiment's body, which must have commands."""
    entry = experiment.entries["organism"]
    if not commands_of(experiment):
        bodies = steered_bodies()
        options = " with these options" if entry.name in bodies else ""
        raise GaitsimError(
            f"the body {entry.name!r}{options} cannot be steered: it has no steering commands",
            where=f"experiment {experiment.name}",
            allowed=f"a body with steering commands: {', '.join(bodies) or 'none is installed'}",
            remedy="use a preset, such as " + " or ".join(map(repr, entries(STEER))),
        )
    with plugin_errors(entry, "naming its controllers"):
        return tuple(map(str, experiment.organism.controller_names()))


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


def individual_controllers(
    experiment: Experiment, genome: Genomes, reference: str
) -> dict[str, Genomes]:
    """Return an individual's genome, (genes,), as the only controller of its body, by name.

    Args:
        experiment: experiment of the individual.
        genome: genome of the individual.
        reference: how a command refers to the individual, for messages.
    """
    names = _controller_names(experiment)
    if len(names) == 1:
        return {names[0]: genome}
    raise GaitsimError(
        f"the body {experiment.entries['organism'].name!r} needs a controller for each command, "
        "but an individual is only one",
        where=reference,
        allowed="controllers: " + ", ".join(names),
        remedy=f"say which one it replaces: --controller {names[0]}={reference}",
    )


def made_by_hand(experiment: Experiment) -> Genomes | None:
    """Return the first start point of a body without commands; None for other bodies."""
    if offered_commands(experiment):
        return None
    with plugin_errors(experiment.entries["organism"], "returning its start points"):
        return next(iter(experiment.organism.starts().values()), None)


def create_drive(experiment: Experiment, replaced: Mapping[str, str]) -> "SteeredDrive":
    """Return an experiment's body at its start, with the controllers from `controllers_of`."""
    return SteeredDrive(experiment, controllers_of(experiment, replaced))


def individual_drive(reference: str, overrides: Overrides | None = None) -> "SteeredDrive":
    """Return the body of a saved individual at its start, which the individual controls.

    Args:
        reference: individual, as accepted by `--from`.
        overrides: options of its experiment to change, by key.
    """
    saved = find_individual(reference)
    load = partial(parse_experiment, saved.experiment, reference)
    return SteeredDrive(*individual_subject(load, saved.genome, reference, overrides))


def individual_subject(
    load: Callable[[Overrides | None], Experiment],
    genome: Genomes,
    reference: str,
    overrides: Overrides | None = None,
) -> tuple[Experiment, dict[str, Genomes], str]:
    """Return the arguments of a `SteeredDrive` that an individual controls.

    If the body has no commands, its twin in physics plays the individual's gait as a rhythm.

    Args:
        load: function that returns the experiment of the individual with overrides.
        genome: genome of the individual, (genes,).
        reference: how a command refers to the individual, for messages.
        overrides: options of the experiment, or of that of the twin, to change, by key.

    Raises:
        GaitsimError: the body cannot be steered, or its twin cannot play the gait.
    """
    own = Individual(load(None), math.nan, {}, genome=genome)
    if offered_commands(own.experiment) or not has_rhythm_on_twin(own):
        own = replace(own, experiment=load(overrides)).embodied
        assert own.genome is not None, "the given one"
        return own.experiment, individual_controllers(own.experiment, own.genome, reference), ""
    twin, about = rhythm_on_twin(replace(own, source=Path(reference)))
    experiment = with_overrides(twin.experiment, overrides) if overrides else twin.experiment
    assert twin.genome is not None, "the fitted one"
    return experiment, individual_controllers(experiment, twin.genome, reference), about


def driven(individual: Individual, drive: Sequence[Mapping[str, float]]) -> Individual:
    """Return an individual under a drive, with the score of its motion.

    Its body first measures how the gait follows commands, as before a drive with the keyboard. A
    gait of a kinematic body is played by its twin in physics. The motion lasts at least two seconds
    longer than the last entry.

    Args:
        individual: individual of a run.
        drive: commands over time, as in the body's option `drive`.

    Raises:
        GaitsimError: the body cannot be driven, or the drive is invalid.
    """
    entries = _entries(drive)
    if has_rhythm_on_twin(individual):
        individual, _ = rhythm_on_twin(individual)
    experiment, genome = individual.experiment, individual.genome
    organism, entry = experiment.organism, experiment.entries["organism"]
    if genome is None or DRIVE not in type(organism).model_fields:
        what = "a gait from a file" if genome is None else f"the body {entry.name!r}"
        raise GaitsimError(
            f"{what} cannot be driven",
            where=DRIVE,
            allowed="an individual of a body with the option 'drive', such as a legged robot",
        )
    controllers = individual_controllers(experiment, genome, str(individual.source or "drive"))
    with plugin_errors(entry, "preparing to be driven"):
        options = dict(organism.steer(controllers).drive())
    last = entries[-1].get("at", 0.0) if entries else 0.0
    options |= {
        DRIVE: entries,
        "duration": max(float(getattr(organism, "duration", 0.0)), last + LINGER),
    }
    kept = {key: value for key, value in _keys(options).items() if key != f"organism.{WORLD}"}
    found = with_changed_body(individual, kept, DRIVE)
    return replace(found, changes={**individual.changes, f"organism.{DRIVE}": entries})


def _entries(drive: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
    try:
        return [{str(name): float(value) for name, value in entry.items()} for entry in drive]
    except (AttributeError, TypeError, ValueError):
        raise GaitsimError(
            f"not a drive: {drive!r:.200}",
            where=DRIVE,
            allowed='a list of dicts such as {"at": 2.0, "speed": 0.2, "turn": 30.0}',
        ) from None


class SteeredDrive:
    """A steered body, simulated from its start until it crashes.

    Args:
        experiment: experiment of the body.
        controllers: genomes of the controllers, each of shape (genes,), by name.
        about: what the person should know about the body at the start, or ''.

    Attributes:
        experiment: experiment of the body.
        commands: commands of the body; the first one ends the others.
        holds: whether each command selects a controller and holds until the next command.
        command: last command given; the first one at the start.
        size: longest diagonal of the box around the body, m.
        ending: reason why the motion ended; '' until then.
        shares: weight of each controller in the movement, (commands,), with the sum 1; None for a
            body that does not report it.
        given: number of commands given.
        saved: folder of the run in which the drive was last saved; None if it has changed since.
    """

    def __init__(
        self, experiment: Experiment, controllers: Mapping[str, Genomes], about: str = ""
    ) -> None:
        self.experiment, self._about = experiment, about
        self._entry = experiment.entries["organism"]
        self._controllers = controllers
        self.commands = commands_of(experiment)
        self.holds = tuple(controllers) == tuple(command.name for command in self.commands)
        self.restart()

    def restart(self) -> None:
        """Restart the simulation."""
        with plugin_errors(self._entry, "preparing to be steered"):
            steered: object = self.experiment.organism.steer(self._controllers)
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
        self._organism = self.experiment.organism
        if options := self._options():  # the body that repeats the drive also draws it
            self._organism = with_overrides(self.experiment, _keys(options), RECORDED).organism
        self.command = self.commands[0]
        self.given = 0
        self._last: Skeleton | None = None
        self.ending = ""
        self.shares: NDArray[np.float64] | None = None
        self.saved: Path | None = None
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

    def give(self, name: str) -> None:
        """Give the command with this name, which acts from the next frame."""
        self.command = next(command for command in self.commands if command.name == name)
        self.given += 1
        with plugin_errors(self._entry, "receiving a command"):
            self._steered.give(name)

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
            motion = self._steered.advance(frames)
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
        self._last = skeleton
        self._frames += flown
        self.saved = None
        if SHARES in motion and flown:
            self.shares = np.asarray(motion[SHARES][0, flown - 1], dtype=np.float64)
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
        last, frames = self._last, len(self._latest)
        assert last is not None, "a frame is simulated at the start"

        def held(values: NDArray[Any] | None) -> NDArray[Any] | None:
            return None if values is None else np.repeat(values[-1:], frames, axis=0)

        return replace(
            last,
            segments=np.stack(self._latest),
            centre=np.stack(self._centres),
            contacts=held(last.contacts),
            touching=held(last.touching),
            solids=(),
            poses=None,
            damaged=tuple(
                name for name in last.damaged if name in (*last.names, *last.contact_names)
            ),
        )

    @property
    def flies(self) -> bool:
        """Whether the body has no feet."""
        return self._last is None or self._last.contacts is None

    @property
    def facts(self) -> dict[str, str]:
        """The command in force: values with units by name."""
        with plugin_errors(self._entry, "describing what it is asked to do"):
            return {str(name): str(value) for name, value in self._steered.facts().items()}

    @property
    def notice(self) -> str:
        """A sentence that the person should know now, or ''."""
        with plugin_errors(self._entry, "describing what it is asked to do"):
            said = str(self._steered.notice())
        return said if said or self.given else self._about

    @property
    def recordable(self) -> bool:
        """Whether the drive can be saved."""
        return bool(self._options())

    def _options(self) -> dict[str, Any]:
        """Return the options with which the body repeats the drive, by name; {} if it cannot."""
        with plugin_errors(self._entry, "recording a drive"):
            found = dict(self._steered.drive())
        if found and len(self._controllers) != 1:
            raise contract_error(
                self._entry,
                f"records a drive with {len(self._controllers)} controllers",
                "a body with one controller, whose genome moves it",
            )
        return found

    def save(self, out: Path | None = None) -> Path:
        """Save the drive up to now as a run of one generation, and return its folder.

        The champion of the run is the steered individual, whose body repeats the drive. A run can
        be replayed, exported, filmed and shared.

        Args:
            out: folder to create; None for one in `runs/`, named after the experiment. A number is
                added to an existing name.

        Raises:
            GaitsimError: the body cannot repeat the drive, or the folder cannot be created.
        """
        self.check_recordable()
        [genome] = self._controllers.values()
        self.saved = save_drive(self.experiment, genome, self._options(), self.seconds, out)
        return self.saved

    def check_recordable(self) -> None:
        """Check that the drive can be saved."""
        if not self.recordable:
            raise GaitsimError(
                f"drives of the body {self._entry.name!r} cannot be recorded",
                allowed="a body that repeats a drive from its options, such as a legged robot",
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


def save_drive(
    experiment: Experiment,
    genome: Genomes,
    options: Mapping[str, Any],
    seconds: float,
    out: Path | None = None,
) -> Path:
    """Save a drive as a run of one generation; see `SteeredDrive.save`.

    Both individuals of the generation are the driven one, as a generation has at least two.

    Args:
        experiment: experiment of the body.
        genome: genome of the driven individual, (genes,).
        options: options with which the body repeats the drive, by name.
        seconds: length of the drive, s.
        out: folder to create; None for one in `runs/`.
    """
    name = experiment.name.removesuffix(DRIVEN) + DRIVEN
    plain = replace(
        experiment,
        evolution=Evolution(population=2, generations=1),
        islands=ONE_ISLAND,
        worlds=experiment.worlds.own,
        transferability=NO_REALITY,
        reality=None,
        constraints=UNCONSTRAINED,
    )
    driven = with_overrides(
        plain,
        {
            "name": name,
            "description": f"a drive of {seconds:.1f} s, recorded by 'gaitsim steer'",
            "search.plugin": "random",
            **_keys(options),
        },
        RECORDED,
    )
    genomes = np.stack([genome, genome])
    evaluation = evaluate(driven, genomes, 1)
    if 0 in evaluation.reasons:
        raise GaitsimError(
            f"the body cannot repeat the drive: {evaluation.reasons[0]}",
            where=str(experiment.entries["organism"]),
        )
    path = create_run(driven, out, Start(driven.to_toml(), genomes))
    with RunWriter.open(path) as writer:
        for _ in writer.evolve(lambda *_: evaluation):
            pass
    return path


def _keys(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options of a body by key."""
    return {f"organism.{name}": value for name, value in options.items()}


def _until_ground(skeleton: Skeleton) -> int:
    """Return the number of frames before a body without feet hits the ground, or of all frames."""
    if skeleton.contacts is not None:
        return len(skeleton.segments)
    below = np.flatnonzero(skeleton.segments[..., 2].min(axis=(1, 2)) < 0)
    return int(below[0]) if len(below) else len(skeleton.segments)
