"""From a run's champion to its imitator: learnt, played on its own, judged beside its teacher."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.files.writer import Gait, gait_of
from gaitsim.imitation.file import Imitation
from gaitsim.imitation.imitator import mean_square
from gaitsim.imitation.learning import Settings, learn
from gaitsim.imitation.verdict import Performance, performance, played
from gaitsim.individual import Individual


@dataclass(frozen=True, eq=False)
class Teacher:
    """Whom a network imitates.

    Attributes:
        individual: the individual to imitate.
        gait: its joint angles.
        performance: how it does.
        judges: whether the body can play joint angles, so that an imitator is judged, too.
    """

    individual: Individual
    gait: Gait
    performance: Performance
    judges: bool


@dataclass(frozen=True, eq=False)
class Result:
    """What came of a training.

    Attributes:
        settings: of the training.
        imitation: the network and what it plays.
        errors: mean squared error of the next frame after each epoch, (epochs,), rad².
        one_step: the same after all of them.
        free_running: mean squared difference from the teacher's gait when it plays on its own.
        beyond_limits: how many of the angles that it asked for the body did not play as
            asked; None where the body cannot play joint angles.
        performance: how it does; None there, too.
    """

    settings: Settings
    imitation: Imitation
    errors: NDArray[np.float64]
    one_step: float
    free_running: float
    beyond_limits: int | None
    performance: Performance | None


def teacher_of(individual: Individual) -> Teacher:
    """The teacher that a kept individual makes.

    Raises:
        GaitsimError: its body has no joint angles, or they are no gait to learn.
        PluginError: the body or the fitness breaks its contract.
    """
    gait = gait_of(individual)
    if len(gait.angles) < 2 or not np.isfinite(gait.angles).all():
        raise GaitsimError(
            f"the gait of generation {individual.generation} cannot be learnt",
            where=str(individual.source),
            allowed="two frames or more, all angles finite",
        )
    judges = individual.experiment.organism.can_play
    return Teacher(individual, gait, performance(individual.experiment, individual.motion), judges)


def imitate(
    teacher: Teacher, settings: Settings, progress: Callable[[int], object] = lambda epochs: None
) -> Result:
    """Train a network, let it play on its own for as many frames, and judge it.

    Raises:
        GaitsimError: the training ran away.
        PluginError: the body or the fitness breaks its contract.
    """
    gait, experiment = teacher.gait, teacher.individual.experiment
    imitator, errors = learn(gait.angles, settings, progress)
    asked = imitator.free_run(gait.angles[0], len(gait.angles))
    angles, beyond, judged = asked, None, None
    if teacher.judges:
        motion, angles, beyond = played(experiment, asked)
        judged = performance(experiment, motion)
    return Result(
        settings=settings,
        imitation=Imitation(
            joint_angles=angles,
            asked=asked,
            frame_rate=gait.frame_rate,
            joint_names=gait.joint_names,
            generation=gait.generation,
            imitator=imitator,
            seed=settings.seed,
        ),
        errors=errors,
        one_step=imitator.one_step_error(gait.angles),
        free_running=mean_square(asked - gait.angles),
        beyond_limits=beyond,
        performance=judged,
    )
