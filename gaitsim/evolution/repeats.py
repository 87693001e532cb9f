"""Many repeats of one experiment, evolved side by side.

A small population costs more in calls than in arithmetic: a hundred repeats of ten
millipedes cost little more than one. The repeats share each generation's random streams
and are told apart by their place in them; so a set of repeats is a function of
experiment and number, but its first repeat is not what `gaitsim run` finds.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.evaluation import Evaluation
from gaitsim.evolution.breeding import breed_each, initial_populations
from gaitsim.evolution.islands import migrated
from gaitsim.experiment import Experiment, Islands


@dataclass(frozen=True, eq=False)
class RepeatedGeneration:
    """One generation of all repeats.

    Attributes:
        number: from 1.
        evaluations: made so far by each repeat.
        best: best score so far of each repeat, (repeats,); −inf where none was finite.
    """

    number: int
    evaluations: int
    best: NDArray[np.float64]


def evolve_repeats(
    experiment: Experiment, evaluate: Callable[[Genomes], Evaluation], repeats: int
) -> Iterator[RepeatedGeneration]:
    """Evolve `repeats` populations to the experiment's last generation.

    Conditions that would stop a single run earlier do not stop repeats, which have to
    stay comparable.

    Args:
        experiment: what to evolve, and how.
        evaluate: scores a population; is given all repeats' genomes as one.
        repeats: how many.

    Yields:
        Each finished generation.
    """
    space = experiment.space()
    population, islands = experiment.evolution.population, experiment.islands
    populations = repeats * islands.number
    best = np.full(repeats, -np.inf)
    scores = np.empty((populations, population))
    for number in range(1, experiment.evolution.generations + 1):
        if number == 1:
            genomes = initial_populations(experiment, space, populations)
        else:
            if (number - 1) % islands.every == 0:
                genomes, scores = _migrated_each(islands, genomes, scores)
            genomes = breed_each(experiment, space, genomes, scores, number)
        everyone = genomes.reshape(populations * population, space.genes)
        scores = evaluate(everyone).scores.reshape(populations, population)
        best = np.maximum(best, scores.reshape(repeats, -1).max(axis=1))
        yield RepeatedGeneration(number, number * experiment.individuals, best)


def _migrated_each(
    islands: Islands, genomes: Genomes, scores: NDArray[np.float64]
) -> tuple[Genomes, NDArray[np.float64]]:
    """`migrated` in every repeat, whose islands follow one another."""
    arrived = [
        migrated(
            islands, genomes[first : first + islands.number], scores[first : first + islands.number]
        )
        for first in range(0, len(genomes), islands.number)
    ]
    return (
        np.concatenate([populations for populations, _ in arrived]),
        np.concatenate([values for _, values in arrived]),
    )
