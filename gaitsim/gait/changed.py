"""Move a gait on another body: with changed options, damaged, or its twin in another engine."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Organism
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.evaluation.worlds import World, conditions_of, describe
from gaitsim.experiment import WORLD, Experiment, load_experiment, with_overrides
from gaitsim.gait.gait_files import GaitFile, play_gait
from gaitsim.gait.report import analyse_individual, quantities
from gaitsim.individual import Individual, Measurement
from gaitsim.legged import STRIDE_FREQUENCY, angles_frequency
from gaitsim.registry import plugin_errors


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


KEY = "organism.damage"


def can_be_damaged(experiment: Experiment) -> bool:
    """Return whether the body has the option `damage`."""
    return "damage" in type(experiment.organism).model_fields


def damage_body(experiment: Experiment, damage: Sequence[str]) -> Experiment:
    """Return an experiment with damage to its body, such as 'L2 lost'."""
    _require_damage(experiment)
    return with_body(experiment, {KEY: [*damage]}, f"damage {', '.join(damage)!r}")


def with_damage(individual: Individual, damage: Sequence[str]) -> Individual:
    """Return an individual with a damaged body, and the score of its motion.

    The damage replaces any earlier damage of the body.

    Args:
        individual: individual of a run or from a file.
        damage: damaged legs and joints, such as 'L2 lost' or 'R1 femur stuck 20'.
    """
    _require_damage(individual.experiment)
    return with_changed_body(individual, {KEY: [*damage]}, f"damage {', '.join(damage)!r}")


def _require_damage(experiment: Experiment) -> None:
    if not can_be_damaged(experiment):
        raise GaitsimError(
            f"the body {experiment.entries['organism'].name!r} cannot be damaged",
            allowed="a body with the option 'damage', such as the spider",
            key=KEY,
        )


class QuantityPair(NamedTuple):
    """A quantity of a gait on two bodies.

    Attributes:
        name: name of the quantity.
        own: value on the body that the gait evolved on; NaN if that body does not have it.
        other: value on the other body.
        unit: unit of both values.
        help: description of the quantity.
    """

    name: str
    own: float
    other: float
    unit: str
    help: str


def has_twin(individual: Individual) -> bool:
    """Return whether the body declares a twin, which can play its joint angles in physics."""
    return _has_twin(individual.experiment)


def twin_of(
    experiment: Experiment, damage: Sequence[str] = (), world: World | None = None
) -> Experiment:
    """Return the experiment of a body's twin in rigid-body physics.

    Args:
        experiment: experiment with the kinematic body.
        damage: damage to the twin.
        world: conditions of the twin's world; None for the world of its preset.
    """
    if not _has_twin(experiment):
        raise GaitsimError(
            f"{experiment.entries['organism']} has no twin in rigid-body physics",
            allowed="a kinematic body whose plugin declares a twin, such as the spider",
        )
    twin = load_experiment(experiment.organism.twin)
    if damage:
        twin = damage_body(twin, damage)
    return put_in_world(twin, world) if world else twin


def play_on_twin(individual: Individual, damage: Sequence[str] | None = None) -> Individual:
    """Play the joint angles of an individual on its body's twin in physics, in the same world.

    Args:
        individual: individual of a kinematic body with a twin.
        damage: damage to the twin; None for the damage of the individual's own body.
    """
    damage = individual.damage if damage is None else damage
    return play_on(individual, _own_twin(individual, damage))


def _own_twin(individual: Individual, damage: Sequence[str]) -> Experiment:
    """Return the twin of an individual's body, in the same world and with its dimensions."""
    twin = twin_of(individual.experiment, damage, individual.world)
    dimensions = getattr(individual.body, "dimensions", {})
    return with_body(twin, {"organism.dimensions": dimensions}) if dimensions else twin


FARTHEST = 5.0  # °, root mean square of the differences up to which a fitted gait is the same gait


def has_rhythm_on_twin(individual: Individual) -> bool:
    """Return whether gaits of a body follow commands on its twin only."""
    organism = individual.experiment.organism
    return (
        individual.genome is not None
        and type(organism).controller is Organism.controller
        and has_twin(individual)
    )


def rhythm_on_twin(individual: Individual) -> tuple[Individual, str]:
    """Return the gait of an individual's twin that is closest to its joint angles.

    The joint angles of the last whole strides are fitted, without the start of the gait.

    Returns:
        The individual of the twin, whose gait follows commands, and a sentence for the user: the
        bodies, and the largest difference of a joint angle.

    Raises:
        GaitsimError: the body has no twin whose gaits follow commands, or the twin cannot play the
            gait, as it is not periodic or far from any gait of the twin.
    """
    body = individual.experiment.entries["organism"].name
    twin = _own_twin(individual, individual.damage)
    gait, rate = _gait_file(individual), individual.motion.frame_rate
    angles = gait.in_order(tuple(twin.organism.joint_names()))
    frequency = _stride_frequency(individual, angles)
    strides = int(len(angles) / 2 / rate * frequency)
    if not strides:
        raise _no_rhythm(individual, "no stride repeats")
    whole = angles[-round(strides / frequency * rate) :]
    with plugin_errors(twin.entries["organism"], "fitting a gait"):
        fitted = twin.organism.fit_gait(whole, frequency, rate)
    if fitted is None:
        raise _no_rhythm(individual, f"the body of {twin.name} has no method fit_gait()")
    difference = np.degrees(fitted.joint_angles - whole)
    apart = math.sqrt(np.square(difference).mean())
    if apart > FARTHEST:
        raise _no_rhythm(individual, f"{apart:.1f}° from the nearest gait of {twin.name}")
    changes = {f"organism.{name}": value for name, value in fitted.options.items()}
    twin = with_overrides(twin, {"name": individual.experiment.name, **changes}, "the fitted gait")
    moved = replace(individual, experiment=twin, genome=fitted.genome, played=None, changes={})
    found = evaluate_motion(twin, moved.motion, 1)
    largest = math.ceil(10 * np.abs(difference).max()) / 10
    about = (
        f"The {body}'s gait, played by {individual.experiment.organism.twin} as a rhythm with "
        f"reflexes: joint angles within {largest:.1f}°."
    )
    score = float(found.scores[0])
    return replace(moved, score=score, terms=found.terms_of(0), played=moved.motion), about


def _stride_frequency(individual: Individual, angles: NDArray[np.float64]) -> float:
    """Return the stride frequency of an individual, Hz; 0 if its gait is not periodic."""
    motion = individual.motion
    known = float(motion[STRIDE_FREQUENCY][0]) if STRIDE_FREQUENCY in motion else 0.0
    return known or float(angles_frequency(angles[None], motion.frame_rate)[0])


def _no_rhythm(individual: Individual, reason: str) -> GaitsimError:
    body = individual.experiment.entries["organism"].name
    return GaitsimError(
        f"the {body}'s gait cannot be played as a rhythm: {reason}",
        where=str(individual.source or individual.name),
        allowed=f"a gait whose joints follow sines to within {FARTHEST:g}° (root mean square)",
        remedy="use a gait with the encoding 'sine' or 'cpg', or evolve one on "
        f"{individual.experiment.organism.twin}",
    )


def play_on(individual: Individual, twin: Experiment) -> Individual:
    """Play the joint angles of an individual on another body, such as the twin of its own."""
    return play_gait(_gait_file(individual), twin)


def _gait_file(individual: Individual) -> GaitFile:
    """Return the joint angles of an individual, as if read from a file."""
    angles = individual.joint_angles
    assert angles is not None, "the body has the channel joint_angles"
    return GaitFile(
        individual.source or Path(individual.name),
        angles,
        individual.motion.frame_rate,
        tuple(individual.experiment.organism.joint_names()),
    )


def compare_bodies(individual: Individual, other: Individual) -> tuple[QuantityPair, ...]:
    """Return the quantities of a gait on its own body and on another body, such as its twin.

    These are the quantities of the gait analysis, and all measures of the other body, such as
    energy.
    """
    return tuple(_pair_quantities(_quantities(individual), _quantities(other)))


def _has_twin(experiment: Experiment) -> bool:
    organism = experiment.organism
    return bool(organism.twin) and "joint_angles" in organism.channels


def _quantities(individual: Individual) -> dict[str, Measurement]:
    return quantities(analyse_individual(individual)) | individual.measurements


def _pair_quantities(
    own: Mapping[str, Measurement], others: Mapping[str, Measurement]
) -> Iterator[QuantityPair]:
    for name, (value, unit, meaning) in others.items():
        found = own.get(name)
        known = found is not None and found.unit == unit
        first = found.value if known and found else math.nan
        yield QuantityPair(name, first, value, unit, meaning)
