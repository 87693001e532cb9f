"""The terms and measures that a search and the transferability model read."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Measure, Motion
from gaitsim.errors import GaitsimError, nearest
from gaitsim.experiment import CONSTRAINTS, FEATURES, TRANSFERABILITY, Experiment
from gaitsim.registry import Entry, contract_error, plugin_errors
from gaitsim.registry.python_plugins import OBJECTIVE

Scores = NDArray[np.float64]
TERM = "term:"
"""Prefix for a term that has the same name as a measure."""


def values_to_read(
    experiment: Experiment, motion: Motion, scores: Scores, terms: Mapping[str, Scores]
) -> dict[str, Scores]:
    """Return the terms and measures to read, by name, each (population,) float64.

    These are the objectives or axes of the search and, in an experiment with a reality, the
    features of the transferability model. The transferability itself is predicted later.
    """
    with plugin_errors(experiment.entries["search"], "naming the values it reads"):
        names = [name for name in experiment.search.reads() if name != TRANSFERABILITY]
    bounded = experiment.constraints.names
    if not names and f"{OBJECTIVE} 1" in terms:
        search = experiment.entries["search"].name
        raise GaitsimError(
            f"the body returned {len(terms)} objectives, but the search {search!r} maximises one "
            "score",
            allowed="one score for each individual; or a dict of terms, whose sum is the score",
            remedy="pass objectives=('max', 'min') to find trade-offs with NSGA-II",
        )
    if not (names or bounded) and experiment.reality is None:
        return {}
    body = experiment.entries["organism"]
    with plugin_errors(body, "measuring a population"):
        measures = experiment.organism.measures(motion)
    readers = dict.fromkeys(_features(experiment, measures), TRANSFERABILITY)
    readers |= dict.fromkeys(bounded, CONSTRAINTS) | dict.fromkeys(names, "search")
    if bounded:
        readers["score"] = CONSTRAINTS  # without failures by constraints
    found = {"score": scores, **terms, **{f"{TERM}{name}": term for name, term in terms.items()}}
    if unknown := [name for name in readers if name not in found and name not in measures]:
        units = dict.fromkeys(["score", *terms], experiment.fitness.unit)
        units |= {name: measure.unit for name, measure in measures.items()}
        raise GaitsimError(
            f"there is no term or measure {unknown[0]!r}",
            where=f"section {readers[unknown[0]]} of the experiment",
            allowed=", ".join(f"{name} ({unit})" if unit else name for name, unit in units.items()),
            remedy=nearest(unknown[0], list(units)),
        )
    for name in readers:
        if name in measures:
            found[name] = values_of(body, measures, name, len(scores))
    return {name: found[name] for name in readers}


def _features(experiment: Experiment, measures: Mapping[str, Measure]) -> tuple[str, ...]:
    """Return the names of the features of the transferability model; () without reality."""
    if experiment.reality is None:
        return ()
    if features := experiment.transferability.features:
        return features
    if features := tuple(name for name in FEATURES if name in measures):
        return features
    raise GaitsimError(
        f"the body {experiment.entries['organism'].name!r} has none of the default features",
        where=f"key {TRANSFERABILITY}.features",
        allowed=f"any of its measures: {', '.join(measures)}",
    )


def values_of(
    body: Entry, measures: Mapping[str, Measure], name: str, population: int
) -> NDArray[np.float64]:
    """Return a copy of the values of a measure, (population,)."""
    with plugin_errors(body, f"measuring {name!r}"):
        values = np.array(measures[name].values, np.float64)
    if values.shape != (population,):
        raise contract_error(
            body,
            f"returned the measure {name!r} with the shape {values.shape}",
            f"(population,) = ({population},)",
        )
    return values
