"""The gait of an individual: its skeleton's, and what its body knows better.

A word has one value in all views: where the body measures a quantity that the analysis has, too,
the analysis takes the body's. A skeleton shows neither how a round foot rolls nor the plane on
which a tilted body stands.
"""

import math

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.gait.intervals import Floats
from gaitsim.gait.report import GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors

_SI = {"": 1.0, "m": 1.0, "mm": 1e-3, "rad": 1.0, "°": math.radians(1)}


def analyse_individual(individual: Individual) -> GaitAnalysis:
    """Analyse the gait of an individual, by its body's own measures where it has them.

    Raises:
        PluginError: the body cannot be moved or drawn, or its channel `margin` is not as declared.
    """
    organism = individual.experiment.organism
    return analyse_gait(
        individual.skeleton,
        individual.joint_angles,
        dynamic=organism.dynamic,
        margin=_own_margin(individual),
        measured=_measured(individual),
    )


def margin_of(individual: Individual) -> Floats:
    """Return the static stability margin, (frames,), metres; −inf without a foot on the ground.

    It is the body's channel `margin` where there is one.

    Raises:
        GaitsimError: the body has no feet.
    """
    own = _own_margin(individual)
    return stability_margin(individual.skeleton) if own is None else own


def _own_margin(individual: Individual) -> Floats | None:
    entry = individual.experiment.entries["organism"]
    channel = individual.experiment.organism.channels.get("margin")
    if channel is None or channel.axes != ("frames",):
        return None
    with plugin_errors(entry, "computing the channel 'margin'"):
        values = np.asarray(individual.motion["margin"])
    expected = (1, len(individual.skeleton.segments))
    if values.shape != expected:
        raise contract_error(
            entry, f"gave the channel 'margin' with the shape {values.shape}", str(expected)
        )
    return np.asarray(values[0], dtype=np.float64)


def _measured(individual: Individual) -> dict[str, float]:
    """Return the finite measures of the body, in SI units by name; {} where it fails at them."""
    try:
        found = individual.measurements
    except GaitsimError:
        return {}
    return {
        name: one.value * _SI[one.unit]
        for name, one in found.items()
        if one.unit in _SI and math.isfinite(one.value)
    }
