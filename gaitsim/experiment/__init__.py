"""Experiments, which determine every result of a run: read from and written to TOML."""

from gaitsim.experiment.loading import (
    load_experiment as load_experiment,
    parse_experiment as parse_experiment,
    parse_space as parse_space,
    with_overrides as with_overrides,
)
from gaitsim.experiment.model import (
    CONSTRAINTS as CONSTRAINTS,
    FEATURES as FEATURES,
    NO_REALITY as NO_REALITY,
    OWN_WORLD as OWN_WORLD,
    PORTABLE as PORTABLE,
    SCHEMA as SCHEMA,
    TRANSFERABILITY as TRANSFERABILITY,
    WORLD as WORLD,
    Evolution as Evolution,
    Experiment as Experiment,
    Islands as Islands,
    Transferability as Transferability,
    Worlds as Worlds,
)
from gaitsim.experiment.outline import (
    ExperimentOutline as ExperimentOutline,
    read_outline as read_outline,
)
from gaitsim.experiment.overrides import (
    Overrides as Overrides,
    Typed as Typed,
    parse_assignments as parse_assignments,
)
