"""The evolution loop, an iterator of frozen generations: ask, evaluate, tell."""

from gaitsim.evolution.islands import ParallelMap as ParallelMap, island_map as island_map
from gaitsim.evolution.loop import (
    Generation as Generation,
    advance as advance,
    evolve as evolve,
    reevaluate as reevaluate,
)
from gaitsim.evolution.searching import ask as ask, first_population as first_population
from gaitsim.stopping import SearchProgress as SearchProgress, stop_reason as stop_reason
