"""Robustness of a score: the same gait under slightly different conditions."""

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
from gaitsim.experiment import OWN_WORLD, with_overrides
from gaitsim.gait.score_breakdown import term_changes
from gaitsim.individual import Individual
from gaitsim.legged import delay_angles

Angles = NDArray[np.float64]
"""Joint angles over time, (frames, joints), radians."""


def apply_lag(angles: Angles, frames: float) -> Angles:
    """Filter joint angles with a first-order lag with a time constant of `frames` frames."""
    followed = angles.copy()
    share = 1 - np.exp(-1 / frames)
    for frame in range(1, len(angles)):
        followed[frame] = followed[frame - 1] + share * (angles[frame] - followed[frame - 1])
    return followed


def interpolate_every_second(angles: Angles) -> Angles:
    """Replace every second frame of joint angles with the mean of its neighbours."""
    result = angles.copy()
    between = result[1:-1:2]
    result[1:-1:2] = (angles[: len(between) * 2 : 2] + angles[2 : len(between) * 2 + 1 : 2]) / 2
    return result


def mirrored_joints(joints: tuple[str, ...]) -> list[int] | None:
    """Return the index of each joint's partner on the other side; None if the names have no sides.

    'L1 coxa' and 'R1 coxa' are partners, as are 'left knee' and 'right knee'. A positive angle is
    assumed to have the same meaning on both sides, such as forward or up. A joint without a side
    is its own partner.
    """
    found = []
    for joint in joints:
        other = _partner(joint)
        if other is not None and other not in joints:
            return None
        found.append(joints.index(other if other is not None else joint))
    return found if any(index != own for own, index in enumerate(found)) else None


def _partner(joint: str) -> str | None:
    for one, other in (("left", "right"), ("Left", "Right")):
        for here, there in ((one, other), (other, one)):
            if here in joint:
                return joint.replace(here, there, 1)
    if joint[:1] in ("L", "R") and (joint[1:2].isdigit() or joint[1:2] in (" ", "_", "-")):
        return ("R" if joint[0] == "L" else "L") + joint[1:]
    return None


SEED = 0
DRAWS = 10  # draws of each random perturbation; their mean score counts
OFFSET, NOISE = 1.0, 0.5  # standard deviation of a servo's offset, and of each frame, degrees
LATE = (1, 2, 3)  # delays of all joints, frames
JOINT_DELAY = 1  # largest delay of single joints, frames
LAG, LONG_LAG = 1, 3  # time constants of a first-order lag, frames
GENE_NOISE = 0.01  # standard deviation, as a share of the range of a gene
STEP_OPTIONS = ("dt", "time_step")
COLLAPSE = 0.5  # fall from which a score has collapsed, as a share of `Robustness.worth`
EXPLOIT, FRAGILE = "likely exploit", "fragile"


@dataclass(frozen=True)
class Perturbation:
    """The score under one perturbation.

    Attributes:
        name: name of the perturbation.
        score: score, or the mean score of several draws.
        fall: decrease of the score, as a share of `Robustness.worth`; 0 if the score rose.
        sign: interpretation of a collapse, 'likely exploit' of the model or 'fragile' gait; '' if
            the score did not collapse.
    """

    name: str
    score: float
    fall: float
    sign: str


@dataclass(frozen=True)
class Robustness:
    """Robustness of a score to perturbations.

    Attributes:
        score: score without perturbations.
        worth: reference for falls: the increase of the score over the best score in the first
            generation of the stage, or the absolute value of the score, whichever is larger.
        perturbations: score under each perturbation.
        missing: perturbations that the body does not support, with reasons.
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
    """Play a gait under all perturbations that its body supports.

    Args:
        individual: individual with the gait.
        history: history of the run; {} for none.
        begin: called with the number of kinds of perturbations.
        advance: called after each kind.
    """
    if individual.worlds:  # perturb in the world of the motion; the history has other worlds
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
    """Raised for a perturbation that the body does not support."""


def _perturbation(name: str, score: float, value: float, worth: float, sign: str) -> Perturbation:
    fall = max(score - value, 0.0) / worth if worth else 0.0
    return Perturbation(name, value, fall, sign if fall > COLLAPSE else "")


def _perturb_all_joints(individual: Individual) -> dict[str, float]:
    """Delay, slow down or mirror all joints equally, which hardly changes a walk."""
    angles = _playable_angles(individual, "late, lagging and mirrored joints")
    played: dict[str, Angles] = {"played again": angles[None]}
    for frames in LATE:
        played[f"all joints {_frames(frames)} late"] = delay_angles(angles, frames)[None]
    played[f"servos with a lag of {_frames(LAG)}"] = apply_lag(angles, LAG)[None]
    played["every second frame left out"] = interpolate_every_second(angles)[None]
    body = individual.body
    # The angles of a real robot rarely have the same sign on both sides.
    pairs = None if body.dynamic else mirrored_joints(body.joint_names())
    if pairs is not None:
        played["mirrored"] = angles[None, :, pairs]
    return _scores(individual, played)


def _perturb_single_joints(individual: Individual) -> dict[str, float]:
    """Perturb each joint independently, or slow down all joints strongly."""
    angles, rng = _playable_angles(individual, "inexact joints"), np.random.default_rng([SEED, 1])
    joints, body = angles.shape[1:], individual.body
    turns = np.array([name not in body.sliding_joints() for name in body.joint_names()])
    late = [delay_angles(angles, rng.integers(0, JOINT_DELAY + 1, joints)) for _ in range(DRAWS)]
    offset = rng.normal(0, np.radians(OFFSET), (DRAWS, 1, angles.shape[1])) * turns
    noise = rng.normal(0, np.radians(NOISE), (DRAWS, *angles.shape)) * turns
    return _scores(
        individual,
        {
            f"servos with a lag of {_frames(LONG_LAG)}": apply_lag(angles, LONG_LAG)[None],
            f"each joint 0 or {_frames(JOINT_DELAY)} late": np.stack(late),
            f"each joint off by about {OFFSET:g}°": angles + offset,
            f"noise of {NOISE:g}° in every frame": angles + noise,
        },
    )


def _playable_angles(individual: Individual, what: str) -> Angles:
    """Return the joint angles, (frames, joints), of a body that can play them."""
    try:
        require_play(individual.embodied.experiment)
    except GaitsimError as error:
        raise _NotPossibleError(f"{what}: {error.what}") from None
    return np.asarray(individual.joint_angles)


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"


def _scores(individual: Individual, played: Mapping[str, Angles]) -> dict[str, float]:
    """Return the mean score of joint angles on a body, (draws, frames, joints), by name."""
    experiment = individual.embodied.experiment
    return {
        name: float(evaluate_motion(experiment, play(experiment, draws), len(draws)).scores.mean())
        for name, draws in played.items()
    }


def _perturb_genes(individual: Individual) -> dict[str, float]:
    """Change the genes slightly."""
    experiment, genome = individual.experiment, individual.genome
    if genome is None:
        raise _NotPossibleError("inexact genes: a gait from a file has no genes")
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
        raise _NotPossibleError(
            "inexact genes: gaitsim cannot make small changes to genomes of the kind "
            f"{space.name!r}"
        )
    return {name: float(evaluate(experiment, copies).scores.mean())}


def _halve_time_step(individual: Individual) -> dict[str, float]:
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


# A collapse under a perturbation that hardly affects a walk indicates an exploit. A collapse under
# a perturbation of the coordination of the legs shows how exactly a robot must follow the gait.
_ATTEMPTS = (
    (_perturb_all_joints, EXPLOIT),
    (_halve_time_step, EXPLOIT),
    (_perturb_single_joints, FRAGILE),
    (_perturb_genes, FRAGILE),
)
