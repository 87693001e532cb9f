"""What is analysed: a run's champion, or a gait from a file on the body of the run."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Motion, Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.experiment import Experiment
from gaitsim.gait.files.reader import GaitFile
from gaitsim.runs.replay import Replay, skeleton_of

_SAME_RATE = 1e-3  # by which frame rates may differ, as a file rounds them


@dataclass(frozen=True, eq=False)
class Subject:
    """One individual's motion, and how it is judged.

    Attributes:
        title: what it is, in words.
        experiment: whose body moves and whose fitness judges.
        motion: of a population of one.
        generation: in which it was found; None for a file.
        recorded: its score as the run has it; None for a file.
        genome: (genes,); None for a file.
    """

    title: str
    experiment: Experiment
    motion: Motion
    generation: int | None = None
    recorded: float | None = None
    genome: NDArray[Any] | None = None

    @cached_property
    def skeleton(self) -> Skeleton:
        """Its body over time."""
        return skeleton_of(self.experiment, self.motion)

    @cached_property
    def terms(self) -> dict[str, float]:
        """What its score is the sum of."""
        return terms_of(self.experiment, self.motion)

    @property
    def score(self) -> float:
        """Its score, of the motion as it is played now."""
        return sum(self.terms.values())

    @property
    def joint_angles(self) -> NDArray[np.float64] | None:
        """(frames, joints), radians; None where the body has none."""
        if "joint_angles" not in self.experiment.organism.channels:
            return None
        return np.asarray(self.motion["joint_angles"][0], dtype=np.float64)


def champion(replay: Replay) -> Subject:
    """A generation's best."""
    return Subject(
        f"{replay.run.path}, best of generation {replay.generation}",
        replay.experiment,
        replay.motion,
        replay.generation,
        replay.score,
        replay.genome,
    )


def from_file(file: GaitFile, experiment: Experiment) -> Subject:
    """A gait from a file, played on the body of an experiment.

    Raises:
        GaitsimError: the body cannot play it, or it has other joints or another frame rate.
    """
    motion = play(experiment, file.in_order(experiment.organism.joint_names())[None])
    rate = motion.frame_rate
    if file.frame_rate is not None and abs(file.frame_rate / rate - 1) > _SAME_RATE:
        raise GaitsimError(
            f"{file.path} has {file.frame_rate:g} frames a second",
            allowed=f"{rate:g} Hz, at which this body plays",
            remedy="resample it first",
        )
    return Subject(f"{file.path} on the {experiment.entries['organism'].name}", experiment, motion)


def terms_of(experiment: Experiment, motion: Motion) -> dict[str, float]:
    """The terms of the score of the first individual of a motion.

    Raises:
        PluginError: the fitness cannot judge it.
    """
    evaluation = evaluate_motion(experiment, motion, motion.population)
    return {name: float(values[0]) for name, values in evaluation.terms.items()}
