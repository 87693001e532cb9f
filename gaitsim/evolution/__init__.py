"""The evolution loop, an iterator of frozen generations: ask, evaluate, tell."""

from gaitsim.evolution.generation import Generation, Progress
from gaitsim.evolution.islands import ParallelMap, island_map
from gaitsim.evolution.loop import advance, evolve, reevaluate, stop_reason
from gaitsim.evolution.searching import ask, first_population

__all__ = [
    "Generation",
    "ParallelMap",
    "Progress",
    "advance",
    "ask",
    "evolve",
    "first_population",
    "island_map",
    "reevaluate",
    "stop_reason",
]
