"""Many repeats of one experiment, evolved side by side.

A small population costs more in calls than in arithmetic: a hundred repeats of ten
millipedes cost little more than one. The repeats share each generation's random streams
and are told apart by their place in them; so a set of repeats is a function of
experiment and number, but its first repeat is not what `gaitsim run` finds.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.evaluation import Evaluation
from gaitsim.evolution.breeding import breed, initial_population
from gaitsim.evolution.islands import migrated
from gaitsim.experiment import Experiment


def evolve_repeats(
    experiment: Experiment, evaluate: Callable[[Genomes], Evaluation], repeats: int
) -> Iterator[NDArray[np.float64]]:
    """Evolve `repeats` populations to the experiment's last generation.

    Other stop conditions do not apply, so that repeats stay comparable.

    Args:
        experiment: what to evolve, and how.
        evaluate: scores a population; called with the genomes of all repeats.
        repeats: number of repeats.

    Yields:
        After each generation the best score so far of each repeat, (repeats,); −inf where none
        was finite. Each repeat has evaluated `experiment.individuals` more.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    space = experiment.space()
    population, islands = experiment.evolution.population, experiment.islands
    populations = repeats * islands.number
    best = np.full(repeats, -np.inf)
    scores = np.empty((populations, population))
    for number in range(1, experiment.evolution.generations + 1):
        if number == 1:
            genomes = initial_population(experiment, space, populations=populations)
            genomes = genomes.reshape(populations, population, space.genes)
        else:
            if islands.immigrants and (number - 1) % islands.every == 0:
                each = zip(np.split(genomes, repeats), np.split(scores, repeats), strict=True)
                arrived = [migrated(islands, *repeat) for repeat in each]
                genomes, scores = map(np.concatenate, zip(*arrived, strict=True))
            genomes = breed(experiment, space, genomes, scores, number)
        everyone = genomes.reshape(-1, space.genes)
        scores = evaluate(everyone).scores.reshape(populations, population)
        best = np.maximum(best, scores.reshape(repeats, -1).max(axis=1))
        yield best
