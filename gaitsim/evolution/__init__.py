"""The search: one pure breeding step, and the loop as an iterator of frozen events."""

from gaitsim.evolution.breeding import breed, initial_population
from gaitsim.evolution.generation import Generation, Progress
from gaitsim.evolution.islands import ParallelMap, island_map
from gaitsim.evolution.loop import advance, evolve, stop_reason

__all__ = [
    "Generation",
    "ParallelMap",
    "Progress",
    "advance",
    "breed",
    "evolve",
    "initial_population",
    "island_map",
    "stop_reason",
]
