"""The contracts of plugins: the base classes that plugins extend, and the types that they use."""

from gaitsim.contracts.condition import SEED, WORLD_HELP, Condition, check_world
from gaitsim.contracts.fitness import Fitness
from gaitsim.contracts.motion import Array, Channel, Measure, Motion, Skeleton
from gaitsim.contracts.operators import Crossover, Mutation, Selection
from gaitsim.contracts.organism import BodyFile, Facts, Organism
from gaitsim.contracts.plugin import Plugin, folder_of, option
from gaitsim.contracts.rig import Link, Rig
from gaitsim.contracts.search import Context, Members, Operators, Results, Search, State
from gaitsim.contracts.solid import Solid
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace
from gaitsim.contracts.steering import Command, Steered, SteeringPage
from gaitsim.contracts.terrain import Terrain

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
    "Facts",
    "Fitness",
    "GenomeSpace",
    "Genomes",
    "Link",
    "Measure",
    "Members",
    "Motion",
    "Mutation",
    "Operators",
    "Organism",
    "Plugin",
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
    "Terrain",
    "check_world",
    "folder_of",
    "option",
]
