"""The contracts of plugins: the base classes that plugins extend, and the types that they use."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitsim.contracts.conditions import SEED as SEED
    from gaitsim.contracts.conditions import WORLD_HELP as WORLD_HELP
    from gaitsim.contracts.conditions import Condition as Condition
    from gaitsim.contracts.conditions import Terrain as Terrain
    from gaitsim.contracts.conditions import check_world as check_world
    from gaitsim.contracts.motion import Array as Array
    from gaitsim.contracts.motion import Channel as Channel
    from gaitsim.contracts.motion import Measure as Measure
    from gaitsim.contracts.motion import Motion as Motion
    from gaitsim.contracts.motion import Skeleton as Skeleton
    from gaitsim.contracts.organism import BodyFile as BodyFile
    from gaitsim.contracts.organism import Facts as Facts
    from gaitsim.contracts.organism import Organism as Organism
    from gaitsim.contracts.plugin import Plugin as Plugin
    from gaitsim.contracts.plugin import folder_of as folder_of
    from gaitsim.contracts.plugin import option as option
    from gaitsim.contracts.product import Exported as Exported
    from gaitsim.contracts.product import Exporter as Exporter
    from gaitsim.contracts.product import Names as Names
    from gaitsim.contracts.product import Pair as Pair
    from gaitsim.contracts.product import Plot as Plot
    from gaitsim.contracts.product import Product as Product
    from gaitsim.contracts.product import Subject as Subject
    from gaitsim.contracts.product import Window as Window
    from gaitsim.contracts.rig import Link as Link
    from gaitsim.contracts.rig import Rig as Rig
    from gaitsim.contracts.rig import Solid as Solid
    from gaitsim.contracts.search import Context as Context
    from gaitsim.contracts.search import Crossover as Crossover
    from gaitsim.contracts.search import Fitness as Fitness
    from gaitsim.contracts.search import Members as Members
    from gaitsim.contracts.search import Mutation as Mutation
    from gaitsim.contracts.search import Operators as Operators
    from gaitsim.contracts.search import Results as Results
    from gaitsim.contracts.search import Search as Search
    from gaitsim.contracts.search import Selection as Selection
    from gaitsim.contracts.search import State as State
    from gaitsim.contracts.space import BitSpace as BitSpace
    from gaitsim.contracts.space import Genomes as Genomes
    from gaitsim.contracts.space import GenomeSpace as GenomeSpace
    from gaitsim.contracts.space import RealSpace as RealSpace
    from gaitsim.contracts.steering import Command as Command
    from gaitsim.contracts.steering import Steered as Steered
    from gaitsim.contracts.steering import SteeringPage as SteeringPage

# Imported at first use: declaring the options of a command needs no NumPy.
_MODULES = {
    "Array": "motion",
    "BitSpace": "space",
    "BodyFile": "organism",
    "Channel": "motion",
    "Command": "steering",
    "Condition": "conditions",
    "Context": "search",
    "Crossover": "search",
    "Exported": "product",
    "Exporter": "product",
    "Facts": "organism",
    "Fitness": "search",
    "GenomeSpace": "space",
    "Genomes": "space",
    "Link": "rig",
    "Measure": "motion",
    "Members": "search",
    "Motion": "motion",
    "Mutation": "search",
    "Names": "product",
    "Operators": "search",
    "Organism": "organism",
    "Pair": "product",
    "Plot": "product",
    "Plugin": "plugin",
    "Product": "product",
    "RealSpace": "space",
    "Results": "search",
    "Rig": "rig",
    "SEED": "conditions",
    "Search": "search",
    "Selection": "search",
    "Skeleton": "motion",
    "Solid": "rig",
    "State": "search",
    "Steered": "steering",
    "SteeringPage": "steering",
    "Subject": "product",
    "Terrain": "conditions",
    "WORLD_HELP": "conditions",
    "Window": "product",
    "check_world": "conditions",
    "folder_of": "plugin",
    "option": "plugin",
}
__all__ = [
    "SEED",
    "WORLD_HELP",
    "Array",
    "BitSpace",
    "BodyFile",
    "Channel",
    "Command",
    "Condition",
    "Context",
    "Crossover",
    "Exported",
    "Exporter",
    "Facts",
    "Fitness",
    "GenomeSpace",
    "Genomes",
    "Link",
    "Measure",
    "Members",
    "Motion",
    "Mutation",
    "Names",
    "Operators",
    "Organism",
    "Pair",
    "Plot",
    "Plugin",
    "Product",
    "RealSpace",
    "Results",
    "Rig",
    "Search",
    "Selection",
    "Skeleton",
    "Solid",
    "State",
    "Steered",
    "SteeringPage",
    "Subject",
    "Terrain",
    "Window",
    "check_world",
    "folder_of",
    "option",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
