"""Analyse the gait of an individual, from its skeleton and from measures of its body.

Each quantity has one value everywhere: if the body measures a quantity of the analysis, the
analysis uses the body's value. A skeleton shows neither how a round foot rolls nor the plane on
which a tilted body stands.
"""

import math

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.gait.intervals import Floats
from gaitsim.gait.report import GaitAnalysis, analyse_gait
from gaitsim.gait.support import stability_margin
from gaitsim.gait.travel import frames_in
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors

_SI = {"": 1.0, "s": 1.0, "m": 1.0, "mm": 1e-3, "rad": 1.0, "°": math.radians(1)}


def analyse_individual(individual: Individual) -> GaitAnalysis:
    """Analyse the gait of an individual; the body's own measures take precedence."""
    organism = individual.experiment.organism
    return analyse_gait(
        individual.skeleton,
        individual.joint_angles,
        dynamic=organism.dynamic,
        margin=_own_margin(individual),
        measured=_measured(individual),
        carried=_carried(individual),
    )


def vertical_loads(individual: Individual) -> Floats | None:
    """Return the vertical force of the ground on each foot, (frames, feet) N.

    Return None if the body has no channel `load` over frames and feet with a component z.
    """
    channel = individual.experiment.organism.channels.get("load")
    if channel is None or channel.axes[:2] != ("frames", "feet") or "z" not in channel.axes[-1]:
        return None
    values = _channel(individual, "load")
    return values[..., channel.axes[-1].index("z")]


def weight_of(individual: Individual) -> float | None:
    """Return the weight of the body, N; None if it has no channel `weight` with a single value."""
    channel = individual.experiment.organism.channels.get("weight")
    return float(_channel(individual, "weight")) if channel and channel.axes == () else None


def frames_before_fall(individual: Individual) -> int:
    """Return the number of frames before a fall, from the channel `lasted`, or all frames."""
    frames = len(individual.skeleton.segments)
    channel = individual.experiment.organism.channels.get("lasted")
    if channel is None or channel.axes or channel.unit != "s":
        return frames
    lasted = float(_channel(individual, "lasted"))
    return min(frames, frames_in(lasted, individual.skeleton.frame_rate))


def _carried(individual: Individual) -> Floats | None:
    """Return the share of the weight that the feet carry, (frames,)."""
    loads, weight = vertical_loads(individual), weight_of(individual)
    return loads.sum(axis=1) / weight if loads is not None and weight else None


def _channel(individual: Individual, name: str) -> Floats:
    """Return a channel of one individual, without the axis of the population."""
    entry = individual.experiment.entries["organism"]
    channel = individual.experiment.organism.channels[name]
    with plugin_errors(entry, f"computing the channel {name!r}"):
        values = np.asarray(individual.motion[name])
    if values.shape[:1] != (1,) or not channel.fits(values.shape):
        raise contract_error(
            entry, f"returned the channel {name!r} with the shape {values.shape}", channel.shape
        )
    return np.asarray(values[0], dtype=np.float64)


def margin_of(individual: Individual) -> Floats:
    """Return the static stability margin, (frames,), metres; −inf without a foot on the ground.

    The channel `margin` of the body, if it has one, takes precedence over its skeleton.
    """
    own = _own_margin(individual)
    return stability_margin(individual.skeleton) if own is None else own


def _own_margin(individual: Individual) -> Floats | None:
    channel = individual.experiment.organism.channels.get("margin")
    if channel is None or channel.axes != ("frames",):
        return None
    margin = _channel(individual, "margin")
    expected = (len(individual.skeleton.segments),)
    if margin.shape != expected:
        entry = individual.experiment.entries["organism"]
        raise contract_error(
            entry,
            f"returned the channel 'margin' with the shape (1, {len(margin)})",
            f"(1, {expected[0]})",
        )
    return margin


def _measured(individual: Individual) -> dict[str, float]:
    """Return the finite measures of the body in SI units, by name; {} if measuring fails."""
    try:
        found = individual.measurements
    except GaitsimError:
        return {}
    return {
        name: one.value * _SI[one.unit]
        for name, one in found.items()
        if one.unit in _SI and math.isfinite(one.value)
    }
