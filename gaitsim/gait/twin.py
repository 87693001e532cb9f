"""Compare a gait on two bodies: a kinematic body and its twin in physics, or two engines."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import World
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.gait.changed import put_in_world
from gaitsim.gait.damaged import damage_body
from gaitsim.gait.files.reader import GaitFile, play_gait
from gaitsim.gait.individual_analysis import analyse_individual
from gaitsim.gait.quantities import quantities
from gaitsim.individual import Individual, Measurement


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
    return play_on(individual, twin_of(individual.experiment, damage, individual.world))


def play_on(individual: Individual, twin: Experiment) -> Individual:
    """Play the joint angles of an individual on another body, such as the twin of its own."""
    angles = individual.joint_angles
    assert angles is not None, "the body has the channel joint_angles"
    gait = GaitFile(
        individual.source or Path(individual.name),
        angles,
        individual.motion.frame_rate,
        tuple(individual.experiment.organism.joint_names()),
    )
    return play_gait(gait, twin)


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
