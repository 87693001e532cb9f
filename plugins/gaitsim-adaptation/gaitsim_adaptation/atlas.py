"""The experiment of an atlas: the best gait of a body for each duty factor of each leg."""

from collections.abc import Mapping, Sequence
from typing import Any

from gaitsim.plugin import (
    EXPERIMENTS,
    GaitsimError,
    contract_error,
    entries,
    options,
    plugin_errors,
)
from gaitsim.plugin.runs import COMMAND_LINE, Experiment, Overrides, Typed, load_experiment
from gaitsim.plugin.toolkit import DUTY

SUFFIX = "-atlas"  # suffix of the name of a body's atlas preset
SHARE = 0.0, 1.0
Axes = Mapping[str, tuple[float, float] | None]

_SEARCH = "map-elites"
_CELLS = 15_625  # Voronoi cells for more than four axes: 5 along each of 6, as in Cully et al.
_LEAST = 100  # smallest population
_PER_CELL = 20  # evaluations per cell


def load_atlas(
    body: str,
    *,
    axes: Axes | None = None,
    cells: int | Sequence[int] | None = None,
    set: Overrides | None = None,
    place: str = COMMAND_LINE,
) -> Experiment:
    """Return the experiment that fills an atlas of a body's gaits, for `evolve`.

    This is the preset `BODY-atlas` if it exists. Otherwise it is the body's experiment with the
    search `map-elites`; legs share no genes, and the axes are the duty factors of the legs.
    Source: Cully, Clune, Tarapore and Mouret 2015, "Robots that can adapt like animals".

    Args:
        body: name of a preset, or path of a TOML file or a robot's file.
        axes: low and high end of each axis, by the name of a measure or term. The ends of a duty
            factor may be None, for 0 to 1. None uses the duty factor of each leg.
        cells: number of Voronoi cells, or the number of cells of a grid along each axis.
        set: values of options by key, such as `{"seed": 3}`.
        place: origin of the options, for messages.

    Raises:
        ExperimentError: the experiment has problems.
        GaitsimError: the preset or file does not exist, no axes are given for a body without legs,
            or an axis that is not a duty factor has no ends.
    """
    given = dict(set or {})
    if axes is not None:
        given["search.axes"] = {name: _ends(name, ends) for name, ends in axes.items()}
    if cells is not None:
        given["search.cells"] = cells if isinstance(cells, int) else list(cells)
    if f"{body}{SUFFIX}" in entries(EXPERIMENTS):
        return load_experiment(f"{body}{SUFFIX}", given, place)
    body_options = {key: value for key, value in given.items() if key.startswith("organism.")}
    found = load_experiment(body, body_options, place)
    if found.search.keeps == "archive":
        return load_experiment(body, given, place)
    return load_experiment(body, _atlas_options(found, given) | given, place)


def _atlas_options(found: Experiment, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that turn an experiment into the experiment of an atlas."""
    axes = given.get("search.axes")
    if isinstance(axes, Typed):
        axes = options.parse_value(str(axes))
    if not isinstance(axes, Mapping):  # missing, or of an invalid type, reported later
        axes = dict.fromkeys(_duty_factors(found), SHARE)
    cells = _CELLS if len(axes) > 4 else 1_000
    population = max(found.evolution.population, _LEAST)
    derived: dict[str, Any] = {
        "name": f"{found.name}{SUFFIX}",
        "description": f"the best gait of {found.name} in each cell of an archive",
        "evolution.population": population,
        "evolution.generations": max(found.evolution.generations, _PER_CELL * cells // population),
        "search.plugin": _SEARCH,
        "search.axes": axes,
        "search.cells": cells,
    }
    # Stop conditions on the best score would end the search before the archive is filled.
    for name in ("target_score", "stagnation"):
        if getattr(found.evolution, name) is not None:
            derived[f"evolution.{name}"] = options.NOT_SET
    if "symmetry" in type(found.organism).model_fields:  # legs that share genes step alike
        derived["organism.symmetry"] = "none"
    return derived


def _duty_factors(found: Experiment) -> list[str]:
    """Return the names of the duty factors of the legs."""
    entry = found.entries["organism"]
    with plugin_errors(entry, "naming its legs"):
        legs: object = found.organism.leg_joints()
    if not isinstance(legs, Mapping):
        what = f"returned a {type(legs).__name__} from leg_joints()"
        raise contract_error(entry, what, "a mapping")
    if legs:
        return [f"{DUTY} {leg}" for leg in legs]
    import numpy as np

    with plugin_errors(entry, "measuring an individual"):
        genomes = found.space().random(1, np.random.default_rng(0))
        measures = found.organism.measures(found.organism.move(genomes))
        known = [f"{name} ({one.unit})" if one.unit else name for name, one in measures.items()]
    raise GaitsimError(
        f"the body {entry.name!r} has no legs whose duty factors could be the axes of an atlas",
        allowed=", ".join(known) or "none, because the body has no measures",
        remedy="choose some of these measures as axes: --axes NAME=LOW:HIGH" * bool(known),
    )


def _ends(name: str, ends: tuple[float, float] | None) -> tuple[float, float]:
    if ends is not None:
        return ends
    if name == DUTY or name.startswith(f"{DUTY} "):
        return SHARE
    raise GaitsimError(
        f"no range is given for the axis {name!r}",
        where="axes",
        allowed=f"a range, such as '{name}=0:2'; only duty factors have a default, 0:1",
    )
