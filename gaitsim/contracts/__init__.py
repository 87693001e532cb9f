"""The contracts of plugins: the base classes that plugins extend, and the types that they use."""

from gaitsim.contracts.conditions import SEED, WORLD_HELP, Condition, Terrain, check_world
from gaitsim.contracts.motion import Array, Channel, Measure, Motion, Skeleton
from gaitsim.contracts.organism import BodyFile, Facts, Organism
from gaitsim.contracts.plugin import Plugin, folder_of, option
from gaitsim.contracts.rig import Link, Rig, Solid
from gaitsim.contracts.search import (
    Context,
    Crossover,
    Fitness,
    Members,
    Mutation,
    Operators,
    Results,
    Search,
    Selection,
    State,
)
from gaitsim.contracts.space import BitSpace, Genomes, GenomeSpace, RealSpace
from gaitsim.contracts.steering import Command, Steered, SteeringPage

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
