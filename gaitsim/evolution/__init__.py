"""The evolution loop, an iterator of frozen generations: ask, evaluate, tell."""

from gaitsim.evolution.islands import ParallelMap, island_map
from gaitsim.evolution.loop import Generation, advance, evolve, reevaluate
from gaitsim.evolution.searching import ask, first_population
from gaitsim.stopping import SearchProgress, stop_reason

__all__ = [
    "Generation",
    "ParallelMap",
    "SearchProgress",
    "advance",
    "ask",
    "evolve",
    "first_population",
    "island_map",
    "reevaluate",
    "stop_reason",
]
