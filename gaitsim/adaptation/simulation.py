"""Trials in simulation: on the damaged body, or on its damaged physical twin."""

from collections.abc import Sequence
from dataclasses import replace

from gaitsim.adaptation.performance import performance_of
from gaitsim.adaptation.prior import Prior
from gaitsim.adaptation.trials import Measured
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment, with_overrides
from gaitsim.individual import Individual


def in_simulation(prior: Prior, damage: Sequence[str]) -> Measured:
    """Return a function that measures gaits on the damaged body; a gait that fails measures 0.

    Several threads may call it.

    Args:
        prior: of the intact body.
        damage: texts as `gaitsim.legged.parse_damage` reads them.

    Raises:
        GaitsimError: the body cannot have this damage.
    """
    damaged = _damaged(prior.experiment, damage)

    def measured(individual: Individual) -> float:
        motion = replace(individual, experiment=damaged).motion
        return float(performance_of(damaged, motion, prior.measure)[0])

    return measured


def _damaged(experiment: Experiment, damage: Sequence[str]) -> Experiment:
    if "damage" not in type(experiment.organism).model_fields:
        raise GaitsimError(
            f"{experiment.entries['organism']} cannot be damaged",
            where=experiment.name,
            allowed="a body with the option 'damage', such as the spider",
        )
    return with_overrides(experiment, {"organism.damage": list(damage)})
