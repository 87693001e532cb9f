"""The performance of gaits: a measure of their motion, where more is better."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Measure, Motion
from gaitsim.errors import unknown
from gaitsim.evaluation.scoring import move_genomes
from gaitsim.evaluation.values import values_of
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_errors

DEFAULT_MEASURE = "forward"
Floats = NDArray[np.float64]


def performance(experiment: Experiment, genomes: Genomes, measure: str) -> Floats:
    """Simulate genomes, (population, genes), and return their performance, (population,).

    The performance is the measure of a gait, or 0 if the gait fails or the measure is not finite.
    """
    return performance_of(experiment, move_genomes(experiment, genomes), measure)


def performance_of(experiment: Experiment, motion: Motion, measure: str) -> Floats:
    """Return the performance of the gaits in a motion, (population,); see `performance`."""
    known = _measures(experiment, motion, measure)
    values = values_of(experiment.entries["organism"], known, measure, motion.population)
    values[list(motion.failures)] = 0.0
    return np.where(np.isfinite(values), values, 0.0)


def unit_of(experiment: Experiment, genomes: Genomes, measure: str) -> str:
    """Return the unit of a measure; simulates one genome."""
    return str(_measures(experiment, move_genomes(experiment, genomes[:1]), measure)[measure].unit)


def _measures(experiment: Experiment, motion: Motion, measure: str) -> Mapping[str, Measure]:
    """Return the measures of a motion, after checking that they include `measure`."""
    body = experiment.entries["organism"]
    with plugin_errors(body, "measuring a population"):
        known: Mapping[str, Measure] = experiment.organism.measures(motion)
    if measure not in known:
        raise unknown("measure", measure, known, where=str(body))
    return known
