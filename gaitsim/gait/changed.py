"""Move a gait on a body with changed options, such as one in another world."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.evaluation.worlds import World, conditions_of, describe
from gaitsim.experiment import WORLD, Experiment, with_overrides
from gaitsim.individual import Individual


def with_changed_body(
    individual: Individual, overrides: Mapping[str, Any], request: str = ""
) -> Individual:
    """Return an individual with changed options of its body, and the score of its new motion.

    A genome moves the changed body; a gait from a file is played on it. The score is computed in
    the body's own world, even if the run evaluated individuals in several worlds.

    Args:
        individual: individual of a run or from a file.
        overrides: values of the body's options by key, such as `{"organism.gravity": 1.6}`.
        request: text of the user's request, which messages show instead of the option's key.
    """
    experiment = with_body(individual.experiment, overrides, request)
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
        changes={**individual.changes, **overrides},
    )


def engine_of(individual: Individual) -> str:
    """Return the physics engine of an individual's body; '' for a body without a choice."""
    return str(getattr(individual.experiment.organism, "engine", ""))


def in_engine(individual: Individual, engine: str) -> Individual:
    """Return an individual whose body moves in a given physics engine."""
    experiment = individual.experiment
    if "engine" not in type(experiment.organism).model_fields:
        raise GaitsimError(
            f"the body {experiment.entries['organism'].name!r} has only one engine",
            where=f"--engine {engine}",
            allowed="a body with the option 'engine', such as the robot",
        )
    return with_changed_body(individual, {"organism.engine": engine}, f"--engine {engine}")


def with_body(
    experiment: Experiment, overrides: Mapping[str, Any], request: str = ""
) -> Experiment:
    """Return an experiment with changed options of its body, and only the body's own world.

    Args:
        experiment: original experiment, which is not changed.
        overrides: values of the body's options by key.
        request: text of the user's request, which messages show instead of the option's key.
    """
    try:
        return replace(with_overrides(experiment, overrides), worlds=experiment.worlds.own)
    except ExperimentError as error:
        if len(error.problems) > 1:
            raise
        [problem] = error.problems
        problem.where = request or problem.where
        raise problem from None


def with_world(individual: Individual, world: World) -> Individual:
    """Return an individual whose body moves in another world, and the score of its motion there.

    Args:
        individual: individual of a run or from a file.
        world: values of conditions by name, such as `{"friction": 0.4}`; others do not change.
    """
    return with_changed_body(
        individual, _options(individual.experiment, world), f"world {describe(world)!r}"
    )


def put_in_world(experiment: Experiment, world: World) -> Experiment:
    """Return an experiment with its body in a world given by the user."""
    return with_body(experiment, _options(experiment, world), f"world {describe(world)!r}")


def _options(experiment: Experiment, world: World) -> dict[str, World]:
    """Return the overrides that put a body into a world."""
    conditions_of(experiment)  # raises an error for a body without conditions
    return {f"organism.{WORLD}": {**getattr(experiment.organism, WORLD), **world}}
