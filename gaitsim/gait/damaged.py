"""Move a gait on a damaged body."""

from collections.abc import Sequence

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.gait.changed import with_body, with_changed_body
from gaitsim.individual import Individual

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
