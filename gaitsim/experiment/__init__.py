"""Experiments, which determine every result of a run: read from and written to TOML."""

from gaitsim.experiment.atlas import load_atlas
from gaitsim.experiment.loading import (
    load_experiment,
    parse_experiment,
    parse_space,
    with_overrides,
)
from gaitsim.experiment.model import (
    PORTABLE,
    SCHEMA,
    Evolution,
    Experiment,
    Islands,
)
from gaitsim.experiment.outline import ExperimentOutline, read_outline
from gaitsim.experiment.overrides import parse_assignments
from gaitsim.experiment.problems import Overrides, Typed
from gaitsim.experiment.transferability import (
    FEATURES,
    NO_REALITY,
    TRANSFERABILITY,
    Transferability,
)
from gaitsim.experiment.worlds import OWN_WORLD, WORLD, Worlds

__all__ = [
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
    "load_atlas",
    "load_experiment",
    "parse_assignments",
    "parse_experiment",
    "parse_space",
    "read_outline",
    "with_overrides",
]
