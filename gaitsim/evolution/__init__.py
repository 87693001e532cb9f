"""The search: one pure breeding step, and the loop as an iterator of frozen events."""

from gaitsim.evolution.breeding import breed, first_population
from gaitsim.evolution.generation import Generation, Progress
from gaitsim.evolution.islands import Spread, spreading
from gaitsim.evolution.loop import evolve, stop_reason
from gaitsim.evolution.stage import rescored, stage_progress

__all__ = [
    "Generation",
    "Progress",
    "Spread",
    "breed",
    "evolve",
    "first_population",
    "rescored",
    "spreading",
    "stage_progress",
    "stop_reason",
]
