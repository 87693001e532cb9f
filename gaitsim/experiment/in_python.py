"""Experiments whose fitness or body is a Python function or object."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from gaitsim.contracts import BitSpace, Organism, RealSpace
from gaitsim.errors import GaitsimError
from gaitsim.experiment.loading import load_experiment, parse_experiment, with_overrides
from gaitsim.experiment.model import Experiment
from gaitsim.experiment.outline import ExperimentOutline
from gaitsim.experiment.problems import COMMAND_LINE
from gaitsim.registry import options
from gaitsim.registry.entry_points import ARGUMENTS, PYTHON
from gaitsim.registry.options import PLUGIN
from gaitsim.registry.python_plugins import python_options

_REAL = '[search]\nplugin = "cma-es"\n'
_BITS = """[selection]
plugin = "tournament"
[crossover]
plugin = "uniform"
[mutation]
plugin = "bit-flip"
"""


def python_experiment(
    experiment: str | Path | Experiment | None,
    overrides: Mapping[str, Any],
    place: str = COMMAND_LINE,
    *,
    fitness: Any = None,
    body: Any = None,
    space: Any = None,
) -> Experiment:
    """Return an experiment with overrides, and with a fitness and a body passed in Python.

    Args:
        experiment: name of a preset, path of a file, or an experiment; None for a body only.
        overrides: values of options by key.
        place: origin of the overrides, for messages.
        fitness: see `gaitsim.evolve`.
        body: see `gaitsim.evolve`.
        space: see `gaitsim.evolve`.
    """
    sections = python_options(fitness, body, space)
    for kind in sections:
        if f"{kind}.{PLUGIN}" in overrides:
            what = (
                f"both the argument {ARGUMENTS[kind]!r} and the option '{kind}.{PLUGIN}' are given"
            )
            raise GaitsimError(what, where=place, remedy="omit one of them")
    given = {**_keys(sections), **overrides}
    text = ""
    if experiment is None:
        text = _default_toml(body, space)
    if "organism" in sections:
        label = getattr(body, "__name__", type(body).__name__).strip("<>")  # '<lambda>'
        given = {"name": label, "description": f"the body {label}", **given}
    if text:
        return parse_experiment(text, "the experiment of a body", given, place)
    if not isinstance(experiment, Experiment):
        return load_experiment(str(experiment), given, place)
    return with_overrides(experiment, given, place) if given else experiment


def _keys(sections: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    return {f"{kind}.{key}": v for kind, table in sections.items() for key, v in table.items()}


def _default_toml(body: Any, space: Any) -> str:
    """Return the TOML of a default search for a body: CMA-ES, or a genetic algorithm for bits."""
    presets = "name a preset to use its search and options: gs.evolve('spider', …)"
    if body is None:
        raise GaitsimError(
            "there is nothing to evolve",
            where="experiment",
            allowed="a preset's name, a path, an experiment, or a body",
            remedy=presets,
        )
    genomes = body.genome_space() if isinstance(body, Organism) else space
    if isinstance(genomes, RealSpace):
        return _REAL
    if isinstance(genomes, BitSpace):
        return _BITS
    what = f"there is no default search for genomes of a {type(genomes).__name__}"
    raise GaitsimError(what, where="experiment", remedy=presets)


def check_functions_match(
    sections: Mapping[str, Mapping[str, Any]], outlines: Collection[ExperimentOutline], where: str
) -> None:
    """Check that the functions passed for a run are those that evolved it, in any stage."""
    for kind, table in sections.items():
        known = [one.plugins[kind] for one in outlines]
        if table[PLUGIN] in known:
            continue
        last, argument = known[-1], ARGUMENTS[kind]
        edited = last.startswith(PYTHON) and _label(last) == _label(table[PLUGIN])
        reason = "the code, the space or the version of Python has changed" if edited else ""
        raise GaitsimError(
            f"the {argument} of the run is {last!r}, not {table[PLUGIN]!r}"
            + (f": {reason}" if reason else ""),
            where=where,
            allowed=f"the {argument} that evolved the run",
            remedy=f"run.resume({argument}=…) continues with another {argument}, as a new stage",
        )


def resumed_options(
    sections: Mapping[str, Mapping[str, Any]], outline: ExperimentOutline
) -> dict[str, Any]:
    """Return the options of functions and objects that differ from those of a run, by key."""
    changed = {
        kind: {key: value for key, value in table.items() if _differs(outline, kind, key, value)}
        for kind, table in sections.items()
    }
    return _keys(changed)


def _differs(outline: ExperimentOutline, kind: str, key: str, value: Any) -> bool:
    now = outline.sections[kind].get(key, options.NOT_SET)
    return bool(now != value)


def _label(name: str) -> str:
    return name.partition("@")[0]
