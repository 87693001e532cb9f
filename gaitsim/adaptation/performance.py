"""The performance of gaits: one measure of their motion, of which more is better."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Measure, Motion
from gaitsim.errors import unknown
from gaitsim.evaluation.scoring import check_motion
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_errors

MEASURE = "forward"
Floats = NDArray[np.float64]


def performance(experiment: Experiment, genomes: Genomes, measure: str) -> Floats:
    """Move genomes, (population, genes), and return a measure of each, (population,).

    It is 0 for a gait that fails, and where the measure is not finite.

    Raises:
        GaitsimError: the body has no such measure.
        PluginError: the body fails or breaks its contract.
    """
    return performance_of(experiment, _moved(experiment, genomes), measure)


def performance_of(experiment: Experiment, motion: Motion, measure: str) -> Floats:
    """Return the performance of a motion, (population,), as `performance` does."""
    found = _measured(experiment, motion, measure)
    with plugin_errors(experiment.entries["organism"], f"measuring {measure!r}"):
        values = np.array(found.values, np.float64)
    values[list(motion.failures)] = 0.0
    return np.where(np.isfinite(values), values, 0.0)


def unit_of(experiment: Experiment, genomes: Genomes, measure: str) -> str:
    """Return the unit of a measure.

    Raises:
        GaitsimError: the body has no such measure.
    """
    return str(_measured(experiment, _moved(experiment, genomes[:1]), measure).unit)


def _moved(experiment: Experiment, genomes: Genomes) -> Motion:
    body = experiment.entries["organism"]
    with plugin_errors(body, "moving a population"):
        return check_motion(body, experiment.organism.move(genomes.copy()))


def _measured(experiment: Experiment, motion: Motion, measure: str) -> Measure:
    body = experiment.entries["organism"]
    with plugin_errors(body, "measuring a population"):
        known: Mapping[str, Measure] = experiment.organism.measures(motion)
    if measure not in known:
        raise unknown("measure", measure, known, where=str(body))
    return known[measure]
