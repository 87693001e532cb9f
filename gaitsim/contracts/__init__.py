"""The contracts of plugins: the base classes that plugins extend, and the types that they use."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsim.contracts.conditions import (
        SEED as SEED,
        WORLD_HELP as WORLD_HELP,
        Condition as Condition,
        Terrain as Terrain,
        check_world as check_world,
    )
    from gaitsim.contracts.motion import (
        Array as Array,
        Channel as Channel,
        Measure as Measure,
        Motion as Motion,
        Skeleton as Skeleton,
    )
    from gaitsim.contracts.organism import (
        BodyFile as BodyFile,
        Facts as Facts,
        FittedGait as FittedGait,
        Organism as Organism,
    )
    from gaitsim.contracts.plugin import (
        Plugin as Plugin,
        folder_of as folder_of,
        option as option,
        roots_of as roots_of,
    )
    from gaitsim.contracts.product import (
        Exported as Exported,
        Exporter as Exporter,
        Names as Names,
        Pair as Pair,
        Plot as Plot,
        Product as Product,
        Subject as Subject,
        Window as Window,
    )
    from gaitsim.contracts.reflex import (
        COMMAND as COMMAND,
        OBSERVATIONS as OBSERVATIONS,
        SAMPLES as SAMPLES,
        Controller as Controller,
        Inputs as Inputs,
        Legs as Legs,
        Observation as Observation,
        Reflex as Reflex,
        Rhythm as Rhythm,
    )
    from gaitsim.contracts.rig import Link as Link, Rig as Rig, Solid as Solid
    from gaitsim.contracts.search import (
        Context as Context,
        Crossover as Crossover,
        Fitness as Fitness,
        Members as Members,
        Mutation as Mutation,
        Operators as Operators,
        Results as Results,
        Search as Search,
        Selection as Selection,
        State as State,
    )
    from gaitsim.contracts.space import (
        BitSpace as BitSpace,
        Genomes as Genomes,
        GenomeSpace as GenomeSpace,
        RealSpace as RealSpace,
    )
    from gaitsim.contracts.steering import (
        Command as Command,
        Steered as Steered,
    )

# Imported at first use: declaring the options of a command needs no NumPy.
_NAMES = {
    "conditions": "Condition SEED Terrain WORLD_HELP check_world",
    "motion": "Array Channel Measure Motion Skeleton",
    "organism": "BodyFile Facts FittedGait Organism",
    "plugin": "Plugin folder_of option roots_of",
    "product": "Exported Exporter Names Pair Plot Product Subject Window",
    "reflex": "COMMAND OBSERVATIONS SAMPLES Controller Inputs Legs Observation Reflex Rhythm",
    "rig": "Link Rig Solid",
    "search": "Context Crossover Fitness Members Mutation Operators Results Search Selection State",
    "space": "BitSpace GenomeSpace Genomes RealSpace",
    "steering": "Command Steered",
}
_MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = [*_MODULES]  # noqa: PLE0604 - names, which a linter cannot see


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found = globals()[name] = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    return found
