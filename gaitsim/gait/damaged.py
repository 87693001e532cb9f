"""A gait on a damaged body."""

from collections.abc import Sequence
from dataclasses import replace

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.experiment import Experiment, with_overrides
from gaitsim.individual import Individual

KEY = "organism.damage"


def can_be_damaged(experiment: Experiment) -> bool:
    """Return whether the body has the option `damage`."""
    return "damage" in type(experiment.organism).model_fields


def damaged(experiment: Experiment, damage: Sequence[str]) -> Experiment:
    """Return the same experiment with this damage to its body, such as 'L2 lost'.

    Raises:
        GaitsimError: the body cannot be damaged, or not like this.
    """
    if not can_be_damaged(experiment):
        raise GaitsimError(
            f"the body {experiment.entries['organism'].name!r} cannot be damaged",
            allowed="a body with the option damage, such as the spider",
            key=KEY,
        )
    try:
        return with_overrides(experiment, {KEY: [*damage]})
    except ExperimentError as error:
        [problem] = error.problems
        problem.where = ", ".join(damage)
        raise problem from None


def with_damage(individual: Individual, damage: Sequence[str]) -> Individual:
    """Return an individual as its damaged body moves, with the score of that motion.

    A gait from a file is played, a genome moves the body. The damage replaces any that the body
    has already.

    Args:
        individual: of a run or from a file.
        damage: legs and joints, such as 'L2 lost' or 'R1 femur stuck 20'.

    Raises:
        GaitsimError: the body cannot be damaged, or not like this.
        PluginError: the body cannot move, or the fitness cannot evaluate it.
    """
    experiment = damaged(individual.experiment, damage)
    angles = individual.joint_angles if individual.genome is None else None
    played = None if angles is None else play(experiment, angles[None])
    motion = replace(individual, experiment=experiment, played=played).motion
    found = evaluate_motion(experiment, motion, 1)
    return replace(
        individual,
        experiment=experiment,
        score=float(found.scores[0]),
        terms=found.terms_of(0),
        played=motion,
    )
