"""Islands: populations that evolve apart and now and then exchange their best.

    bred from generation g:   island 0      island 1      island 2
                              breed         breed         breed        each its own random streams
    g a multiple of `every`:  best ───────▶ worst
                                            best ───────▶ worst
                                                                ──▶ …  then they breed

A generation's genomes are those of all islands, one island after the other, and so are its
scores. Migration is a part of breeding: what is recorded of a generation is from before it.
So a search with islands is, as one without, a function of the generation before.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Genomes, GenomeSpace
from gaitsim.evaluation import Evaluation, Evaluator, judge
from gaitsim.evaluation.judge import joined
from gaitsim.evolution.breeding import breed, first_population, population_from
from gaitsim.experiment import Experiment, Islands

Scores = NDArray[np.float64]


class Spread(Protocol):
    """Does a function of an experiment and a task for all tasks, as `Evaluator.map` does."""

    def __call__(
        self,
        function: "Callable[[Experiment, Stretch], list[Made]]",
        tasks: "Sequence[Stretch]",
        individuals: int = 0,
    ) -> "list[list[Made]]":
        """The results in the tasks' order."""


Made = tuple[Genomes, Evaluation]


@dataclass(frozen=True, eq=False)
class Stretch:
    """Generations of one island between two migrations: a task.

    Attributes:
        island: its number, from 0.
        first: the first generation to make.
        last: the last one.
        genomes: what the first one is bred from, (population, genes), its immigrants among
            them; None where the first one is drawn.
        scores: of these, (population,).
        start: a genome, (genes,), that generation 1 is made of; None draws it.
    """

    island: int
    first: int
    last: int
    genomes: Genomes | None
    scores: Scores | None
    start: Array | None


def by_island(islands: Islands, values: Array) -> Array:
    """What is known of all individuals, (individuals, …), as (islands, population, …)."""
    return values.reshape(islands.number, -1, *values.shape[1:])


def migrated(islands: Islands, genomes: Genomes, scores: Scores) -> tuple[Genomes, Scores]:
    """Copies of each island's best in place of the worst of its neighbours.

    Of equal scores, the first counts as better. The migrants stay at home, too, and all
    islands send before any receives.

    Args:
        islands: which neighbours, how many migrants.
        genomes: (islands, population, genes); not changed.
        scores: (islands, population).

    Returns:
        The same with the migrants arrived, each with its score.
    """
    number, size = scores.shape
    if not islands.immigrants:
        return genomes, scores
    order = np.argsort(-scores, axis=1, kind="stable")
    best, worst = order[:, : islands.migrants], order[:, size - islands.immigrants :]
    genomes, scores, before, values = genomes.copy(), scores.copy(), genomes, scores
    for island in range(number):
        others = (np.arange(1, number) + island) % number
        sources = others[-1:] if islands.topology == "ring" else np.sort(others)
        genomes[island, worst[island]] = before[sources[:, None], best[sources]].reshape(
            -1, before.shape[2]
        )
        scores[island, worst[island]] = values[sources[:, None], best[sources]].reshape(-1)
    return genomes, scores


def next_population(
    experiment: Experiment,
    space: GenomeSpace,
    number: int,
    genomes: Genomes | None,
    scores: Scores | None,
    start: Array | None,
) -> Genomes:
    """Generation `number` of all islands, (individuals, genes).

    Args:
        experiment: its scheme and seed.
        space: the genome space.
        number: of the generation that is made.
        genomes: the generation before, (individuals, genes); None for the first one.
        scores: of these, (individuals,).
        start: a genome, (genes,), that generation 1 is made of; None draws it.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    tasks = _stretches(experiment, number, number, genomes, scores, start)
    return np.concatenate([_bred(experiment, space, task, number) for task in tasks])


def _bred(experiment: Experiment, space: GenomeSpace, task: Stretch, number: int) -> Genomes:
    """One island's population of a generation."""
    if task.genomes is not None and task.scores is not None:
        return breed(experiment, space, task.genomes, task.scores, number, task.island)
    if task.start is not None:
        return population_from(experiment, space, task.start, task.island)
    return first_population(experiment, space, task.island)


def _stretches(
    experiment: Experiment,
    first: int,
    last: int,
    genomes: Genomes | None,
    scores: Scores | None,
    start: Array | None,
) -> list[Stretch]:
    """Each island's stretch of generations, after the migration if one is due before it."""
    islands = experiment.islands
    if genomes is None or scores is None:
        return [Stretch(island, first, last, None, None, start) for island in range(islands.number)]
    populations, values = by_island(islands, genomes), by_island(islands, scores)
    if (first - 1) % islands.every == 0:
        populations, values = migrated(islands, populations, values)
    return [
        Stretch(island, first, last, populations[island], values[island], None)
        for island in range(islands.number)
    ]


def until_migration(experiment: Experiment, first: int) -> int:
    """The last generation that islands can make without one another, from `first` on."""
    every = experiment.islands.every
    return min(-(-first // every) * every, max(experiment.evolution.generations, first))


def stretch(experiment: Experiment, task: Stretch) -> list[Made]:
    """Evolve one island for the generations of its stretch; for a worker.

    Returns:
        Each generation's population and its evaluation.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    space = experiment.space()
    made: list[Made] = []
    genomes, scores = task.genomes, task.scores
    for number in range(task.first, task.last + 1):
        here = Stretch(task.island, number, number, genomes, scores, task.start)
        population = _bred(experiment, space, here, number)
        evaluation = judge(experiment, population)
        made.append((population, evaluation))
        genomes, scores = population, evaluation.scores
    return made


def spreading(evaluator: Evaluator) -> Spread | None:
    """What spreads the evaluator's islands over its workers, at least one for each; else None.

    Where there are fewer islands than workers, or these are threads, all islands are better
    evolved here, generation by generation, and the workers move individuals.
    """
    number = evaluator.experiment.islands.number
    worth = number > 1 and evaluator.elsewhere and number >= evaluator.workers
    return evaluator.map if worth else None


def spread_stretch(
    experiment: Experiment,
    spread: Spread,
    first: int,
    genomes: Genomes | None,
    scores: Scores | None,
    start: Array | None,
) -> Iterator[Made]:
    """Generations of all islands from `first` to the next migration, an island a task.

    Yields:
        Each generation of all islands and its evaluation.

    Raises:
        PluginError: a plugin fails or breaks its contract; names its package.
    """
    last = until_migration(experiment, first)
    tasks = _stretches(experiment, first, last, genomes, scores, start)
    each = experiment.evolution.population * (last - first + 1)
    for islands in zip(*spread(stretch, tasks, each), strict=True):
        populations = np.concatenate([population for population, _ in islands])
        yield populations, joined(experiment, [evaluation for _, evaluation in islands])
