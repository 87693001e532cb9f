"""Robustness of a score: the same gait under slightly different conditions.

A gait that walks loses a little when all servos are late or slow, when its body is mirrored,
or when a simulation takes smaller steps. An exploit of the model, such as joints that flip
between two frames, loses most of its score. Errors of single joints show how exactly a robot
must keep a gait.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import BitSpace, RealSpace
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.playing import play, require_play
from gaitsim.evaluation.scoring import evaluate, evaluate_motion
from gaitsim.experiment import OWN_WORLD, Experiment, with_overrides
from gaitsim.gait.perturbations import Angles, lagging, mirror, without_every_second
from gaitsim.gait.score_breakdown import term_changes
from gaitsim.individual import Individual
from gaitsim.legged import delayed

SEED = 0
DRAWS = 10  # of each perturbation by chance; their mean counts
OFFSET, NOISE = 1.0, 0.5  # degrees, standard deviation: of a servo's trim, and of every frame
LATE = (1, 2, 3)  # frames, all joints alike
APART = 1  # frame at most, each joint on its own
LAG, LONG_LAG = 1, 3  # frames, time constant of a first-order lag
GENE_NOISE = 0.01  # of the width of a gene's bounds
STEP_OPTIONS = ("dt", "time_step")
COLLAPSE = 0.5  # of what the score is worth: with a greater fall, it collapses
EXPLOIT, FRAGILE = "likely exploit", "fragile"


@dataclass(frozen=True)
class Perturbation:
    """The score under one perturbation.

    Attributes:
        name: of the change.
        score: the mean, where it was drawn several times.
        fall: decrease of the score, as a share of `Robustness.worth`; 0 where it rose.
        sign: what a collapse of the score indicates, a 'likely exploit' of the model or a
            'fragile' gait; '' where it does not collapse.
    """

    name: str
    score: float
    fall: float
    sign: str


@dataclass(frozen=True)
class Robustness:
    """Robustness of a score to perturbations.

    Attributes:
        score: unperturbed.
        worth: the reference of falls: how far the score is above the best of the run's first
            generation, or its absolute value, whichever is larger.
        perturbations: the score under each.
        missing: those that this body does not allow, and why.
    """

    score: float
    worth: float
    perturbations: tuple[Perturbation, ...]
    missing: tuple[str, ...]


def measure_robustness(
    individual: Individual,
    history: Mapping[str, NDArray[np.float64]],
    begin: Callable[[int], object] = lambda _: None,
    advance: Callable[[], object] = lambda: None,
) -> Robustness:
    """Play a gait again under all perturbations that its body allows.

    Args:
        individual: whose gait is played.
        history: of the run; {} for none.
        begin: called with the number of kinds of perturbations.
        advance: called after each kind.

    Raises:
        PluginError: the body or the fitness fails.
    """
    if individual.worlds:  # perturbed in the world of the motion; the history is over others
        alone = replace(individual.experiment, worlds=OWN_WORLD)
        individual, history = replace(individual, experiment=alone, played=individual.motion), {}
    score = individual.replayed_score
    if individual.replayed_failure:
        return Robustness(
            score, math.nan, (), (f"the motion fails: {individual.replayed_failure}",)
        )
    worth = abs(score)
    if history:
        generation = individual.best_of or len(history["best"])
        first_best = float(history["best"][term_changes(history, generation)[0] - 1])
        worth = max(worth, score - first_best if np.isfinite(first_best) else 0.0)
    perturbations: list[Perturbation] = []
    missing: list[str] = []
    begin(len(_ATTEMPTS))
    for attempt, sign in _ATTEMPTS:
        try:
            scores = attempt(individual)
        except _NotPossibleError as error:
            missing.append(str(error))
        else:
            perturbations += [
                _perturbation(name, score, value, worth, sign) for name, value in scores.items()
            ]
        advance()
    return Robustness(score, worth, tuple(perturbations), tuple(missing))


class _NotPossibleError(Exception):
    """A perturbation that this body does not allow."""


def _perturbation(name: str, score: float, value: float, worth: float, sign: str) -> Perturbation:
    fall = max(score - value, 0.0) / worth if worth else 0.0
    return Perturbation(name, value, fall, sign if fall > COLLAPSE else "")


def _rhythm(individual: Individual) -> dict[str, float]:
    """Delay, slow down or mirror all joints alike, which hardly changes a walk."""
    angles = _playable(individual, "late, lagging and mirrored joints")
    played: dict[str, Angles] = {"played again": angles[None]}
    for frames in LATE:
        played[f"all joints {_frames(frames)} late"] = delayed(angles, frames)[None]
    played[f"servos with a lag of {_frames(LAG)}"] = lagging(angles, LAG)[None]
    played["every second frame left out"] = without_every_second(angles)[None]
    body = individual.experiment.organism
    # Angles of a real robot seldom count alike on both sides.
    pairs = None if body.dynamic else mirror(body.joint_names())
    if pairs is not None:
        played["mirrored"] = angles[None, :, pairs]
    return _scores(individual.experiment, played)


def _inexact(individual: Individual) -> dict[str, float]:
    """Move each joint on its own away from its angle, or slow down all joints much."""
    angles, rng = _playable(individual, "inexact joints"), np.random.default_rng([SEED, 1])
    apart = [delayed(angles, rng.integers(0, APART + 1, angles.shape[1:])) for _ in range(DRAWS)]
    offset = rng.normal(0, np.radians(OFFSET), (DRAWS, 1, angles.shape[1]))
    noise = rng.normal(0, np.radians(NOISE), (DRAWS, *angles.shape))
    return _scores(
        individual.experiment,
        {
            f"servos with a lag of {_frames(LONG_LAG)}": lagging(angles, LONG_LAG)[None],
            f"each joint 0 or {_frames(APART)} late": np.stack(apart),
            f"each joint off by about {OFFSET:g}°": angles + offset,
            f"noise of {NOISE:g}° in every frame": angles + noise,
        },
    )


def _playable(individual: Individual, what: str) -> Angles:
    """Return the joint angles, (frames, joints), of a body that can play them."""
    try:
        require_play(individual.experiment)
    except GaitsimError as error:
        raise _NotPossibleError(f"{what}: {error.what}") from None
    return np.asarray(individual.joint_angles)


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _scores(experiment: Experiment, played: Mapping[str, Angles]) -> dict[str, float]:
    """Return the mean score of joint angles, (draws, frames, joints), by name."""
    return {
        name: float(evaluate_motion(experiment, play(experiment, these), len(these)).scores.mean())
        for name, these in played.items()
    }


def _genes(individual: Individual) -> dict[str, float]:
    """Change the genes a little."""
    experiment, genome = individual.experiment, individual.genome
    if genome is None:
        raise _NotPossibleError("inexact genes: a gait from a file has none")
    space, rng = experiment.space(), np.random.default_rng([SEED, 2])
    copies: NDArray[Any] = np.repeat(genome[None], DRAWS, axis=0)
    if isinstance(space, RealSpace):
        copies = space.repair(copies + rng.normal(0, GENE_NOISE, copies.shape) * space.width)
        name = f"genes inexact by {GENE_NOISE:.0%} of their range"
    elif isinstance(space, BitSpace):
        copies[np.arange(DRAWS), rng.integers(0, space.genes, DRAWS)] ^= 1
        copies = space.repair(copies)
        name = "one gene flipped"
    else:
        raise _NotPossibleError(f"inexact genes: a {space.name} genome has no small change")
    return {name: float(evaluate(experiment, copies).scores.mean())}


def _half_step(individual: Individual) -> dict[str, float]:
    """Halve the time step of a body that simulates with one."""
    experiment, genome = individual.experiment, individual.genome
    options: Mapping[str, Any] = type(experiment.organism).model_fields
    step = next((name for name in STEP_OPTIONS if name in options), None)
    if step is None:
        raise _NotPossibleError(
            f"half the time step: the body has no option {' or '.join(STEP_OPTIONS)}"
        )
    if genome is None:
        raise _NotPossibleError("half the time step: a gait from a file is not simulated")
    half = getattr(experiment.organism, step) / 2
    try:
        finer = with_overrides(experiment, {f"organism.{step}": half})
    except GaitsimError as error:
        raise _NotPossibleError(f"half the time step: {error.what}") from None
    return {f"half the time step, {half:g} s": float(evaluate(finer, genome[None]).scores[0])}


# A perturbation that hardly affects a walk indicates an exploit. One that affects the coordination
# of the legs, which any gait needs, shows how exactly a robot must keep it.
_ATTEMPTS = ((_rhythm, EXPLOIT), (_half_step, EXPLOIT), (_inexact, FRAGILE), (_genes, FRAGILE))
