"""The names of `import gaitsim as gs`, beside functions that packages add."""

import typing as _typing

from gaitsim.api import (
    Individual as Individual,
    Run as Run,
    RunningSearch as RunningSearch,
    analyse as analyse,
    evolve as evolve,
    export as export,
    load as load,
    picture as picture,
    presets as presets,
    runs as runs,
    share as share,
    verify as verify,
    view as view,
)
from gaitsim.contracts import (
    BitSpace as BitSpace,
    Fitness as Fitness,
    Motion as Motion,
    Organism as Organism,
    RealSpace as RealSpace,
)
from gaitsim.errors import GaitsimError as GaitsimError
from gaitsim.evaluating import evaluate as evaluate
from gaitsim.evaluation import Evaluation as Evaluation
from gaitsim.evolution import Generation as Generation
from gaitsim.experiment import (
    Experiment as Experiment,
    load_experiment as load_experiment,
)
from gaitsim.individual import Member as Member, Numbered as Numbered
from gaitsim.optimiser import Optimiser as Optimiser
from gaitsim.registry.python_plugins import scalar as scalar
from gaitsim.sharing.challenge import Challenge as Challenge

__all__: list[str]

def __getattr__(name: str) -> _typing.Any: ...
