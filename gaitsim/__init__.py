"""Evolve gaits in your terminal; in Python, `import gaitsim as gs`."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsim.actions.export import export as export
    from gaitsim.api import (
        Run as Run,
        RunningSearch as RunningSearch,
        evolve as evolve,
        load as load,
        picture as picture,
        view as view,
    )
    from gaitsim.comparing import Comparison as Comparison, compare as compare
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
        load_atlas as load_atlas,
        load_experiment as load_experiment,
    )
    from gaitsim.imitation.imitating import imitate as imitate
    from gaitsim.individual import Individual as Individual, Member as Member
    from gaitsim.optimiser import Optimiser as Optimiser
    from gaitsim.registry.python_plugins import scalar as scalar
    from gaitsim.sharing.challenge import Challenge as Challenge, verify_code as verify_code

# Imported at first use: `gaitsim --help` needs none of these modules, nor NumPy.
_NAMES = {
    "gaitsim.actions.export": "export",
    "gaitsim.api": "Run RunningSearch evolve load picture view",
    "gaitsim.comparing": "Comparison compare",
    "gaitsim.contracts": "BitSpace Fitness Motion Organism RealSpace",
    "gaitsim.errors": "GaitsimError",
    "gaitsim.evaluating": "evaluate",
    "gaitsim.evaluation": "Evaluation",
    "gaitsim.evolution": "Generation",
    "gaitsim.experiment": "Experiment load_atlas load_experiment",
    "gaitsim.imitation.imitating": "imitate",
    "gaitsim.individual": "Individual Member",
    "gaitsim.optimiser": "Optimiser",
    "gaitsim.registry.python_plugins": "scalar",
    "gaitsim.sharing.challenge": "Challenge verify_code",
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = [*_MODULES]  # noqa: PLE0604 - names, which a linter cannot see


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_MODULES})
