"""Evolve many repeats of an experiment together.

For a small population, function calls cost more than arithmetic: a hundred repeats of ten
millipedes cost little more than one. The repeats of a genetic algorithm share the random streams
of each generation. Their results therefore depend on the number of repeats, and even the first
repeat differs from a run by `gaitsim run`. The repeats of a search with a state have streams of
their own, so any part of them gives the same results alone.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Results
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution.islands import migrate
from gaitsim.evolution.searching import ask, initial_state, reevaluate_remembered, tell
from gaitsim.experiment import Experiment

Scores = NDArray[np.float64]


def evolve_repeats(
    experiment: Experiment,
    evaluate: Evaluate,
    repeats: int,
    *,
    only: Sequence[int] | None = None,
) -> Iterator[Scores]:
    """Evolve `repeats` populations to the experiment's last generation.

    Other stop conditions do not apply, so that repeats stay comparable.

    Args:
        experiment: experiment to repeat.
        evaluate: function that evaluates genomes.
        repeats: number of repeats.
        only: numbers of the repeats to evolve, from 0; None for all. A search that handles
            `several` populations at once evolves all.

    Yields:
        After each generation, the best score so far of each repeat, (repeats,), in the worlds of
        that generation; −inf if none was finite. Each generation adds `experiment.individuals`
        evaluations to each repeat.
    """
    if experiment.search.several:
        evolving = _evolve_stacked(experiment, evaluate, repeats)
    else:
        chosen = range(repeats) if only is None else only
        evolving = _evolve_one_by_one(experiment, evaluate, chosen)
    best = np.array(-np.inf)
    for number, scores in enumerate(evolving, 1):
        best = scores if experiment.worlds.redrawn(number) else np.maximum(best, scores)
        yield best


def _evolve_stacked(experiment: Experiment, evaluate: Evaluate, repeats: int) -> Iterator[Scores]:
    """Yield the best score of each repeat per generation, for a search that handles all at once."""
    space = experiment.space()
    population, islands = experiment.evolution.population, experiment.islands
    populations = repeats * islands.number
    last: Results | None = None
    for number in range(1, experiment.evolution.generations + 1):
        if last is not None and islands.immigrants and (number - 1) % islands.every == 0:
            parts = (np.split(values, repeats) for values in (last.genomes, last.scores))
            migrated = [migrate(islands, *repeat) for repeat in zip(*parts, strict=True)]
            genomes, scores = map(np.concatenate, zip(*migrated, strict=True))
            last = Results(genomes, scores)
        genomes, _ = ask(experiment, space, {}, last, number, populations=(populations,))
        scores = evaluate(genomes.reshape(-1, space.genes), number).scores
        last = Results(genomes, scores.reshape(populations, population))
        yield scores.reshape(repeats, -1).max(axis=1)


def _evolve_one_by_one(
    experiment: Experiment, evaluate: Evaluate, repeats: Sequence[int]
) -> Iterator[Scores]:
    """Yield the best score of each repeat per generation, for a search with a state per repeat.

    Each repeat has its own random streams, like an island.
    """
    space, size = experiment.space(), experiment.evolution.population
    states = [initial_state(experiment, space, island=island) for island in repeats]
    lasts: list[Results | None] = [None] * len(repeats)
    for number in range(1, experiment.evolution.generations + 1):
        asked = [
            ask(experiment, space, state, last, number, island=island)
            for island, state, last in zip(repeats, states, lasts, strict=True)
        ]
        evaluation = evaluate(np.concatenate([genomes for genomes, _ in asked]), number)
        for index, (island, (genomes, state)) in enumerate(zip(repeats, asked, strict=True)):
            rows = slice(index * size, (index + 1) * size)
            values = {name: column[rows] for name, column in evaluation.values.items()}
            lasts[index] = results = Results(genomes, evaluation.scores[rows], values)
            redrawn = experiment.worlds.redrawn(number)
            if redrawn:
                states[index], _ = reevaluate_remembered(
                    experiment, state, evaluate, number, redrawn=True
                )
            else:
                states[index] = state
            states[index] = tell(experiment, space, states[index], results, number, island=island)
        yield evaluation.scores.reshape(len(repeats), -1).max(axis=1)
