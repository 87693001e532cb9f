"""Trials in simulation: on the damaged body, or on the damaged physical twin of the body."""

from collections.abc import Sequence
from dataclasses import replace

from gaitsim.adaptation.performance import MEASURE, performance_of
from gaitsim.adaptation.trials import Measured
from gaitsim.experiment import Experiment
from gaitsim.gait.damaged import damaged
from gaitsim.gait.twin import played_on, twin_of
from gaitsim.individual import Individual


def in_simulation(
    experiment: Experiment,
    damage: Sequence[str],
    measure: str = MEASURE,
    *,
    physics: bool = False,
) -> Measured:
    """Return a function that measures gaits on the damaged body; a gait that fails measures 0.

    Several threads may call it.

    Args:
        experiment: of the intact body.
        damage: legs and joints, such as 'L2 lost' or 'R1 femur stuck 20'.
        measure: name of the measure that is the performance.
        physics: whether the physical twin of the body moves instead.

    Raises:
        GaitsimError: the body cannot be damaged, or not like this; or it has no twin.
    """
    if physics:
        body = twin_of(experiment, damage)
    else:
        body = damaged(experiment, damage) if damage else experiment

    def measured(individual: Individual) -> float:
        moved = played_on(individual, body) if physics else replace(individual, experiment=body)
        return float(performance_of(body, moved.motion, measure)[0])

    return measured
