"""Imitate an individual: train a network, let it play on its own, and evaluate what it plays."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.gait.files.writer import Gait, gait_of
from gaitsim.imitation.file import Imitation
from gaitsim.imitation.learning import Settings, learn
from gaitsim.individual import Individual

TOLERANCE = 1e-6  # rad: smaller differences are rounding, not limits
_FORWARD = "forward"  # the measure of the way that a body walks


@dataclass(frozen=True, eq=False)
class Result:
    """A trained imitator and how it performs.

    Attributes:
        settings: of the training.
        expert: the individual that the network imitates.
        imitation: the network and the gait that it plays.
        errors: mean squared error of the next frame after each epoch, (epochs,), rad².
        one_step: the same after the last epoch.
        free_running: mean squared difference from the expert's gait when it plays on its own.
        played: the imitation on the expert's body, scored; None where the body cannot play
            joint angles.
        beyond_limits: number of commanded angles that the body limited; None there, too.
    """

    settings: Settings
    expert: Individual
    imitation: Imitation
    errors: NDArray[np.float64]
    one_step: float
    free_running: float
    played: Individual | None
    beyond_limits: int | None

    @property
    def forward_kept(self) -> float | None:
        """The share of the expert's way forward, where the body measures it and it is positive."""
        whole = self.expert.measures.get(_FORWARD)
        if self.played is None or whole is None or whole <= 0:
            return None
        reached = self.played.measures.get(_FORWARD)
        return None if reached is None else reached / whole


def learnable_gait(expert: Individual) -> Gait:
    """Return the gait of an individual.

    Raises:
        GaitsimError: its body has no joint angles, or they cannot be learnt.
        PluginError: the body breaks its contract.
    """
    gait = gait_of(expert)
    if len(gait.angles) < 2 or not np.isfinite(gait.angles).all():
        raise GaitsimError(
            f"the gait of generation {expert.generation} cannot be learnt",
            where=str(expert.source),
            allowed="two frames or more, all angles finite",
        )
    return gait


def imitate(
    expert: Individual, settings: Settings, progress: Callable[[int], object] = lambda epochs: None
) -> Result:
    """Train a network, let it play as many frames on its own, and evaluate it.

    Raises:
        GaitsimError: the expert has no gait to learn, or the training diverged.
        PluginError: the body or the fitness breaks its contract.
    """
    gait, experiment = learnable_gait(expert), expert.experiment
    imitator, errors = learn(gait.angles, settings, progress)
    commanded = imitator.free_run(gait.angles[0], len(gait.angles))
    performed, played, beyond = replace(gait, angles=commanded, score=math.nan), None, None
    if experiment.organism.can_play:
        played = Individual.of_motion(experiment, play(experiment, commanded[None]))
        performed = replace(gait, angles=gait_of(played).angles, score=played.score)
        beyond = int(np.count_nonzero(np.abs(performed.angles - commanded) > TOLERANCE))
    return Result(
        settings=settings,
        expert=expert,
        imitation=Imitation(performed, commanded, imitator, settings.seed),
        errors=errors,
        one_step=imitator.one_step_error(gait.angles),
        free_running=float(np.mean((commanded - gait.angles) ** 2)),
        played=played,
        beyond_limits=beyond,
    )
