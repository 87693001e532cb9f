"""Experiments, which determine every result of a run: read from and written to TOML."""

from gaitsim.experiment.loading import (
    load_experiment,
    parse_experiment,
    parse_space,
    with_overrides,
)
from gaitsim.experiment.model import (
    CONSTRAINTS,
    FEATURES,
    NO_REALITY,
    OWN_WORLD,
    PORTABLE,
    SCHEMA,
    TRANSFERABILITY,
    WORLD,
    Evolution,
    Experiment,
    Islands,
    Transferability,
    Worlds,
)
from gaitsim.experiment.outline import ExperimentOutline, read_outline
from gaitsim.experiment.overrides import Overrides, Typed, parse_assignments

__all__ = [
    "CONSTRAINTS",
    "FEATURES",
    "NO_REALITY",
    "OWN_WORLD",
    "PORTABLE",
    "SCHEMA",
    "TRANSFERABILITY",
    "WORLD",
    "Evolution",
    "Experiment",
    "ExperimentOutline",
    "Islands",
    "Overrides",
    "Transferability",
    "Typed",
    "Worlds",
    "load_experiment",
    "parse_assignments",
    "parse_experiment",
    "parse_space",
    "read_outline",
    "with_overrides",
]
