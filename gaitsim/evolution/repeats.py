"""Evolve many repeats of an experiment together.

For a small population, function calls cost more than arithmetic: a hundred repeats of ten
millipedes cost little more than one. The repeats of a genetic algorithm share the random streams
of each generation. Their results therefore depend on the number of repeats, and even the first
repeat differs from a run by `gaitsim run`.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Results
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution.islands import migrate
from gaitsim.evolution.searching import ask, initial_state, reevaluate_remembered, tell
from gaitsim.experiment import Experiment

Scores = NDArray[np.float64]


def evolve_repeats(experiment: Experiment, evaluate: Evaluate, repeats: int) -> Iterator[Scores]:
    """Evolve `repeats` populations to the experiment's last generation.

    Other stop conditions do not apply, so that repeats stay comparable.

    Yields:
        After each generation, the best score so far of each repeat, (repeats,), in the worlds of
        that generation; −inf if none was finite. Each generation adds `experiment.individuals`
        evaluations to each repeat.
    """
    evolve = _evolve_stacked if experiment.search.several else _evolve_one_by_one
    best = np.full(repeats, -np.inf)
    for number, scores in enumerate(evolve(experiment, evaluate, repeats), 1):
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
    experiment: Experiment, evaluate: Evaluate, repeats: int
) -> Iterator[Scores]:
    """Yield the best score of each repeat per generation, for a search with a state per repeat.

    Each repeat has its own random streams, like an island.
    """
    space, size = experiment.space(), experiment.evolution.population
    states = [initial_state(experiment, space, island=index) for index in range(repeats)]
    lasts: list[Results | None] = [None] * repeats
    for number in range(1, experiment.evolution.generations + 1):
        asked = [
            ask(experiment, space, state, last, number, island=index)
            for index, (state, last) in enumerate(zip(states, lasts, strict=True))
        ]
        evaluation = evaluate(np.concatenate([genomes for genomes, _ in asked]), number)
        for index, (genomes, state) in enumerate(asked):
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
            states[index] = tell(experiment, space, states[index], results, number, island=index)
        yield evaluation.scores.reshape(repeats, -1).max(axis=1)
