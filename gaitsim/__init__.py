"""Evolve gaits in your terminal; in Python, `import gaitsim as gs`."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsim.actions.export import export as export
    from gaitsim.api import Run as Run
    from gaitsim.api import RunningSearch as RunningSearch
    from gaitsim.api import evolve as evolve
    from gaitsim.api import load as load
    from gaitsim.api import picture as picture
    from gaitsim.api import view as view
    from gaitsim.comparing import Comparison as Comparison
    from gaitsim.comparing import compare as compare
    from gaitsim.contracts import BitSpace as BitSpace
    from gaitsim.contracts import Fitness as Fitness
    from gaitsim.contracts import Motion as Motion
    from gaitsim.contracts import Organism as Organism
    from gaitsim.contracts import RealSpace as RealSpace
    from gaitsim.errors import GaitsimError as GaitsimError
    from gaitsim.evaluating import evaluate as evaluate
    from gaitsim.evaluation import Evaluation as Evaluation
    from gaitsim.evolution import Generation as Generation
    from gaitsim.experiment import Experiment as Experiment
    from gaitsim.experiment import load_atlas as load_atlas
    from gaitsim.experiment import load_experiment as load_experiment
    from gaitsim.imitation.imitating import imitate as imitate
    from gaitsim.individual import Individual as Individual
    from gaitsim.individual import Member as Member
    from gaitsim.sharing.challenge import Challenge as Challenge
    from gaitsim.sharing.challenge import verify_code as verify_code

# Imported at first use: `gaitsim --help` needs none of these modules, nor NumPy.
_MODULES = {
    "BitSpace": "gaitsim.contracts",
    "Challenge": "gaitsim.sharing.challenge",
    "Comparison": "gaitsim.comparing",
    "Evaluation": "gaitsim.evaluation",
    "Experiment": "gaitsim.experiment",
    "Fitness": "gaitsim.contracts",
    "GaitsimError": "gaitsim.errors",
    "Generation": "gaitsim.evolution",
    "Individual": "gaitsim.individual",
    "Member": "gaitsim.individual",
    "Motion": "gaitsim.contracts",
    "Organism": "gaitsim.contracts",
    "RealSpace": "gaitsim.contracts",
    "Run": "gaitsim.api",
    "RunningSearch": "gaitsim.api",
    "compare": "gaitsim.comparing",
    "evaluate": "gaitsim.evaluating",
    "evolve": "gaitsim.api",
    "export": "gaitsim.actions.export",
    "imitate": "gaitsim.imitation.imitating",
    "load": "gaitsim.api",
    "load_atlas": "gaitsim.experiment",
    "load_experiment": "gaitsim.experiment",
    "picture": "gaitsim.api",
    "verify_code": "gaitsim.sharing.challenge",
    "view": "gaitsim.api",
}
__all__ = [
    "BitSpace",
    "Challenge",
    "Comparison",
    "Evaluation",
    "Experiment",
    "Fitness",
    "GaitsimError",
    "Generation",
    "Individual",
    "Member",
    "Motion",
    "Organism",
    "RealSpace",
    "Run",
    "RunningSearch",
    "compare",
    "evaluate",
    "evolve",
    "export",
    "imitate",
    "load",
    "load_atlas",
    "load_experiment",
    "picture",
    "verify_code",
    "view",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
