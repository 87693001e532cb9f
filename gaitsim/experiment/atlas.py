"""The experiment of an atlas: the best gait of a body for each duty factor of each leg."""

from collections.abc import Mapping, Sequence
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.experiment.loading import load_experiment
from gaitsim.experiment.model import Experiment
from gaitsim.experiment.problems import COMMAND_LINE, Overrides, Typed
from gaitsim.legged.stepping import DUTY
from gaitsim.registry import EXPERIMENTS, contract_error, entries, options, plugin_errors

SUFFIX = "-atlas"  # of the preset of a body's atlas
SHARE = 0.0, 1.0
Axes = Mapping[str, tuple[float, float] | None]

_SEARCH = "map-elites"
_CELLS = 15_625  # Voronoi cells of more than four axes: five along each of six, as Cully et al.
_LEAST = 100  # individuals a generation
_PER_CELL = 20  # evaluations


def load_atlas(
    body: str,
    *,
    axes: Axes | None = None,
    cells: int | Sequence[int] | None = None,
    set: Overrides | None = None,
    place: str = COMMAND_LINE,
) -> Experiment:
    """Return the experiment that fills an atlas of a body's gaits, for `evolve`.

    It is the preset `BODY-atlas` if there is one. Otherwise it is the experiment of the body with
    the search `map-elites`; its axes are the duty factors of the legs (Cully, Clune, Tarapore and
    Mouret 2015, "Robots that can adapt like animals"), and legs share no genes.

    Args:
        body: a preset's name, or the path of a TOML file or a robot's file.
        axes: measures or terms of the score, each with its low and high end; None for an end takes
            0 to 1, the range of a duty factor. None takes the duty factor of each leg.
        cells: a number of Voronoi cells, or counts of a grid, one for each axis.
        set: values of options by key, such as `{"seed": 3}`.
        place: where the options come from, for messages.

    Raises:
        ExperimentError: the experiment has problems.
        GaitsimError: there is no such preset or file, the body has no legs, or an axis that is not
            a duty factor has no ends.
    """
    given = dict(set or {})
    if axes is not None:
        given["search.axes"] = {name: _ends(name, ends) for name, ends in axes.items()}
    if cells is not None:
        given["search.cells"] = cells if isinstance(cells, int) else list(cells)
    if f"{body}{SUFFIX}" in entries(EXPERIMENTS):
        return load_experiment(f"{body}{SUFFIX}", given, place)
    of_body = {key: value for key, value in given.items() if key.startswith("organism.")}
    found = load_experiment(body, of_body, place)
    if found.search.keeps == "archive":
        return load_experiment(body, given, place)
    return load_experiment(body, _derived(found, given) | given, place)


def _derived(found: Experiment, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that make an atlas of an experiment."""
    axes = given.get("search.axes")
    if isinstance(axes, Typed):
        axes = options.parse_value(str(axes))
    if not isinstance(axes, Mapping):  # none are given, or something else, which is reported later
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
    # Conditions on the best score alone would stop before the map is filled.
    for name in ("target_score", "stagnation"):
        if getattr(found.evolution, name) is not None:
            derived[f"evolution.{name}"] = options.NOT_SET
    if "symmetry" in type(found.organism).model_fields:  # legs that share genes step alike
        derived["organism.symmetry"] = "none"
    return derived


def _duty_factors(found: Experiment) -> list[str]:
    """Return the names of the duty factors of the legs.

    Raises:
        GaitsimError: the body has no legs; the message lists its measures.
    """
    entry = found.entries["organism"]
    with plugin_errors(entry, "naming its legs"):
        legs: object = found.organism.leg_joints()
    if not isinstance(legs, Mapping):
        raise contract_error(entry, f"gave a {type(legs).__name__} from leg_joints()", "a mapping")
    if legs:
        return [f"{DUTY} {leg}" for leg in legs]
    import numpy as np

    with plugin_errors(entry, "being measured"):
        genomes = found.space().random(1, np.random.default_rng(0))
        measures = found.organism.measures(found.organism.move(genomes))
        known = [f"{name} ({one.unit})" if one.unit else name for name, one in measures.items()]
    raise GaitsimError(
        f"the body {entry.name!r} has no legs whose duty factors could be the axes of an atlas",
        allowed=", ".join(known) or "none: it has no measures",
        remedy="name some of them as axes, with their ends: --axes NAME=LOW:HIGH" * bool(known),
    )


def _ends(name: str, ends: tuple[float, float] | None) -> tuple[float, float]:
    if ends is not None:
        return ends
    if name == DUTY or name.startswith(f"{DUTY} "):
        return SHARE
    raise GaitsimError(
        f"the axis {name!r} has no ends",
        where="axes",
        allowed=f"a low and a high end, such as '{name}=0:2'; those of duty factors are 0:1",
    )
