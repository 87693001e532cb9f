"""Trials on a real robot: gaits that are played, and a search whose scores people type."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.plugin import GaitsimError, Genomes, RunError, read_regular
from gaitsim.plugin.gait import gait_of
from gaitsim.plugin.runs import (
    EXACT_KEYS,
    LARGEST_SCORE,
    Challenge,
    Individual,
    Optimiser,
    code_of,
    evaluate,
    first_problem,
    write_bytes,
)
from gaitsim_adaptation.answers import Answer
from gaitsim_adaptation.prior import DEFAULT_MEASURE, performance_of
from gaitsim_adaptation.trials import Outcome
from gaitsim_wire.wire import WireOptions

if TYPE_CHECKING:
    from gaitsim_wire.driving import Session

LARGEST = 4_000_000  # bytes
MOST_TRIALS = 10_000
FILE = "trials.json"


@dataclass(frozen=True)
class Played:
    """Measurements of a robot while it played a gait.

    Attributes:
        turned: change of its direction, ° to the left; NaN without an IMU.
        sway: root mean square of its change of direction, rad; NaN without an IMU.
        tilt: largest tilt, °; NaN without an IMU.
    """

    turned: float = math.nan
    sway: float = math.nan
    tilt: float = math.nan

    def __str__(self) -> str:
        if math.isnan(self.turned):
            return ""
        side = "left" if self.turned > 0 else "right"
        return f"It turned {abs(self.turned):.0f}° to the {side}, and tilted {self.tilt:.0f}°."


def play(wire: WireOptions, individual: Individual, path: Path) -> Played:
    """Play a gait once on a robot.

    Args:
        wire: the robot.
        individual: gait to play.
        path: gait file for the telemetry.

    Raises:
        GaitsimError: as `WireOptions.drive`.
        KeyboardInterrupt: the user stopped the robot.
    """
    player, calibration = wire.tape_of(gait_of(individual))
    found = Played()

    def save(session: "Session") -> None:
        nonlocal found
        session.recording.write(path, tuple(calibration.joints))
        found = _felt(*session.recording.felt())

    wire.drive(player, calibration, save=save)
    return found


def _felt(orientation: NDArray[np.float64], driving: NDArray[np.bool_]) -> Played:
    """Return the measurements of an IMU, (frames, 3) rad, while the gait was played, (frames,)."""
    found = orientation[driving & np.isfinite(orientation).all(axis=1)]
    if not len(found):
        return Played()
    yaw = np.unwrap(found[:, 2])
    turned = yaw - yaw[0]
    tilt = np.abs(found[:, :2]).max()
    sway = math.sqrt(float(np.square(turned).mean()))
    return Played(math.degrees(turned[-1]), sway, math.degrees(tilt))


@dataclass(frozen=True)
class RobotTrial:
    """A gait that was played on the robot.

    Attributes:
        genome: genome of the gait, (genes,).
        values: measured distance of each attempt, m.
        outcome: outcome of the trial.
        text: the result as the user typed it.
        sway: root mean square of the robot's change of direction, rad; None if not measured.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    genome: tuple[float, ...]
    values: tuple[float, ...]
    outcome: Outcome
    text: str
    sway: float | None = None

    @property
    def distance(self) -> float:
        """The mean distance, m."""
        return math.fsum(self.values) / max(len(self.values), 1)


@dataclass(frozen=True)
class Log:
    """The content of the file of a search on a robot.

    Attributes:
        code: code of the gait around which the search began.
        population: gaits per generation.
        seed: seed of the search.
        step: standard deviation of the first changes, as a share of each gene's range.
        turn_weight: penalty per radian of sway, m.
        trials: the trials in order.
        format: format of the file.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    code: str
    population: int = 6
    seed: int = 0
    step: float = 0.05
    turn_weight: float = 0.5
    trials: tuple[RobotTrial, ...] = ()
    format: Literal[1] = 1

    def score(self, trial: RobotTrial) -> float:
        """Return the score of a trial, m; NaN for a gait that could not be played."""
        if trial.outcome == "could not play":
            return math.nan
        return trial.distance - self.turn_weight * (trial.sway or 0.0)


_LOG = TypeAdapter(Log)


class RobotSearch:
    """CMA-ES around a gait, whose scores are measured on a robot.

    All genomes follow from the start, the settings and the results so far. A search is therefore
    continued from its results alone, and nothing is lost when it is killed.

    Args:
        path: file of the search.
        log: settings and earlier trials.

    Attributes:
        start: gait around which the search began.
        proposal: genome to try next, (genes,).
        generation: number of its generation, counted from 1.

    Raises:
        RunError: a result belongs to no gait of the search.
        GaitsimError: the code or a setting is invalid.
    """

    def __init__(self, path: Path, log: Log) -> None:
        self.path, self.log, self._saved = path, log, read_log(path)
        self.start = Challenge.read(log.code).individual
        self._follow()

    def _follow(self) -> None:
        """Repeat the search with the results so far, and choose the next genome."""
        log = self.log
        search = Optimiser(
            self.start.experiment.space(),
            population=log.population,
            seed=log.seed,
            start=self.start.genome,
            set={"search.start_step": log.step, "search.restarts": "none"},
        )
        asked, scores = search.ask(), list[float]()
        self.generation = 1
        for number, trial in enumerate(log.trials, 1):
            if trial.genome != tuple(asked[len(scores)].tolist()):
                raise RunError(
                    f"{self.path} is damaged: trial {number} is not a gait of this search",
                    remedy="start a new search in another folder, with --out",
                )
            scores.append(log.score(trial))
            if len(scores) == log.population:
                search.tell(scores)
                asked, scores = search.ask(), []
                self.generation += 1
        self.proposal: Genomes = asked[len(scores)]

    @cached_property
    def expected(self) -> float:
        """The distance that the start walks forward in simulation, m; 0 if its body has none."""
        experiment = self.start.experiment
        try:
            return float(performance_of(experiment, self.start.motion, DEFAULT_MEASURE)[0])
        except GaitsimError:
            return 0.0

    @property
    def best(self) -> RobotTrial | None:
        """The trial with the highest score; None before the first that could be played."""
        played = [trial for trial in self.log.trials if trial.outcome != "could not play"]
        return max(played, key=self.log.score, default=None)

    def individual(self, genome: Sequence[float] | Genomes) -> Individual:
        """Return a gait of the search, as simulated."""
        return replace(self.start, genome=np.array(genome), member=None)

    def code(self, trial: RobotTrial) -> str:
        """Return the code of a gait, with its score in simulation."""
        individual = self.individual(trial.genome)
        score = float(evaluate(individual.experiment, np.array(trial.genome)).scores[0])
        return code_of(replace(individual, score=score))

    def record(self, answer: Answer, played: Played) -> RobotTrial:
        """Add the result of the proposed gait, and save it."""
        sway = None if math.isnan(played.sway) else played.sway
        genome = tuple(self.proposal.tolist())
        trial = RobotTrial(genome, answer.values, answer.outcome, answer.text, sway)
        self._replace((*self.log.trials, trial))
        return trial

    def undo(self) -> None:
        """Remove the last result.

        Raises:
            GaitsimError: there is none.
        """
        if not self.log.trials:
            raise GaitsimError("there is no result to undo", where="undo")
        self._replace(self.log.trials[:-1])

    def _replace(self, trials: tuple[RobotTrial, ...]) -> None:
        if read_log(self.path) != self._saved:
            raise RunError(
                f"{self.path} has changed since it was read: another process is using it",
                remedy="run the same command again to continue",
            )
        log = replace(self.log, trials=trials)
        write_bytes(self.path, _LOG.dump_json(log, indent=1) + b"\n")
        self.log = self._saved = log
        self._follow()


def read_log(path: Path) -> Log | None:
    """Return the content of the file of a search; None if it does not exist.

    Raises:
        RunError: the file cannot be read or is damaged.
    """
    reason = ""
    try:
        log = _LOG.validate_json(read_regular(path, LARGEST), strict=True)
        reason = _inconsistency(log)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}") from None
    except ValidationError as error:
        key, what = first_problem(error, "trials")
        reason = f"{key}: {what}"
    if reason:
        raise RunError(
            f"{path} is damaged: {reason}",
            remedy="start a new search in another folder, with --out",
        )
    return log


def _inconsistency(log: Log) -> str:
    """Return why the content of a file is impossible, or ''."""
    if len(log.trials) > MOST_TRIALS:
        return f"it has {len(log.trials)} trials, more than {MOST_TRIALS}"
    numbers = [log.step, log.turn_weight]
    for trial in log.trials:
        numbers += [*trial.genome, *trial.values, trial.sway or 0.0]
        if not (trial.values and trial.text.isprintable()):
            return "a result has no value, or an invalid text"
    if not all(abs(number) < LARGEST_SCORE for number in numbers):
        return "a value is not a finite number"
    return ""
