"""Imitate a run's champion: train a network, let it play on its own, and evaluate it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait.files.writer import Gait, gait_of
from gaitsim.imitation.file import Imitation
from gaitsim.imitation.imitator import mean_square
from gaitsim.imitation.learning import Settings, learn
from gaitsim.imitation.performance import Performance, performance, played
from gaitsim.individual import Individual


@dataclass(frozen=True, eq=False)
class Expert:
    """The individual that a network imitates.

    Attributes:
        individual: the individual to imitate.
        gait: its joint angles.
        performance: its score and measures.
    """

    individual: Individual
    gait: Gait
    performance: Performance


@dataclass(frozen=True, eq=False)
class Result:
    """A trained imitator and how it performs.

    Attributes:
        settings: of the training.
        imitation: the network and the gait that it plays.
        errors: mean squared error of the next frame after each epoch, (epochs,), rad².
        one_step: the same after the last epoch.
        free_running: mean squared difference from the expert's gait when it plays on its own.
        beyond_limits: number of commanded angles that the body limited; None where the body
            cannot play joint angles.
        performance: its score and measures; None there, too.
    """

    settings: Settings
    imitation: Imitation
    errors: NDArray[np.float64]
    one_step: float
    free_running: float
    beyond_limits: int | None
    performance: Performance | None


def expert_of(individual: Individual) -> Expert:
    """Make an individual the expert of an imitation.

    Raises:
        GaitsimError: its body has no joint angles, or they are not a gait.
        PluginError: the body or the fitness breaks its contract.
    """
    gait = gait_of(individual)
    if len(gait.angles) < 2 or not np.isfinite(gait.angles).all():
        raise GaitsimError(
            f"the gait of generation {individual.generation} cannot be learnt",
            where=str(individual.source),
            allowed="two frames or more, all angles finite",
        )
    return Expert(individual, gait, performance(individual.experiment, individual.motion))


def imitate(
    expert: Expert, settings: Settings, progress: Callable[[int], object] = lambda epochs: None
) -> Result:
    """Train a network, let it play as many frames on its own, and evaluate it.

    Raises:
        GaitsimError: the training diverged.
        PluginError: the body or the fitness breaks its contract.
    """
    gait, experiment = expert.gait, expert.individual.experiment
    imitator, errors = learn(gait.angles, settings, progress)
    commanded = imitator.free_run(gait.angles[0], len(gait.angles))
    angles, beyond, evaluated = commanded, None, None
    if experiment.organism.can_play:
        motion, angles, beyond = played(experiment, commanded)
        evaluated = performance(experiment, motion)
    return Result(
        settings=settings,
        imitation=Imitation(
            joint_angles=angles,
            commanded=commanded,
            frame_rate=gait.frame_rate,
            joint_names=gait.joint_names,
            generation=gait.generation,
            imitator=imitator,
            seed=settings.seed,
        ),
        errors=errors,
        one_step=imitator.one_step_error(gait.angles),
        free_running=mean_square(commanded - gait.angles),
        beyond_limits=beyond,
        performance=evaluated,
    )
