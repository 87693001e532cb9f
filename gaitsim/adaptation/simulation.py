"""Trials in simulation, on the damaged body or on its damaged physical twin."""

from collections.abc import Sequence
from dataclasses import replace

from gaitsim.adaptation.performance import DEFAULT_MEASURE, performance_of
from gaitsim.adaptation.trials import MeasureGait
from gaitsim.experiment import Experiment
from gaitsim.gait.changed import damage_body, play_on, twin_of
from gaitsim.individual import Individual


def simulated_robot(
    experiment: Experiment,
    damage: Sequence[str],
    measure: str = DEFAULT_MEASURE,
    *,
    physics: bool = False,
) -> MeasureGait:
    """Return a function that measures gaits on the damaged body in simulation.

    A failed gait has a performance of 0. Several threads may call the function at the same time.

    Args:
        experiment: experiment with the intact body.
        damage: damaged legs and joints, such as 'L2 lost' or 'R1 femur stuck 20'.
        measure: name of the performance measure.
        physics: whether to use the body's twin, its version in rigid-body physics.
    """
    if physics:
        body = twin_of(experiment, damage)
    else:
        body = damage_body(experiment, damage) if damage else experiment

    def measure_gait(individual: Individual) -> float:
        moved = play_on(individual, body) if physics else replace(individual, experiment=body)
        return float(performance_of(body, moved.motion, measure)[0])

    return measure_gait
