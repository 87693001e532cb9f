"""Islands: populations that evolve separately and occasionally exchange their best individuals.

    after generation g:       island 0      island 1      island 2
    g a multiple of `every`:  best ───────▶ worst
                                            best ───────▶ worst
                                                                ──▶ …
    always:                   ask           ask           ask          with separate random streams

The genomes and scores of a generation are those of all islands, one island after another. The
history records a generation before its migration. With or without islands, each generation is a
function of the previous one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace, Parents, Results
from gaitsim.evaluation import Evaluation, evaluate
from gaitsim.evaluation.scoring import join_evaluations
from gaitsim.evolution.searching import ask
from gaitsim.experiment import Experiment, Islands

if TYPE_CHECKING:
    from gaitsim.evaluation import Evaluator

Scores = NDArray[np.float64]


EvaluatedPopulation = tuple[Genomes, Evaluation]
"""Genomes, (individuals, genes), and their evaluation."""


@dataclass(frozen=True, eq=False)
class Epoch:
    """A task: the generations of one island between two migrations.

    Attributes:
        island: number of the island, counted from 0.
        first: number of the first generation to ask for.
        last: number of the last generation to ask for.
        genomes: population before the first generation, including immigrants,
            (population, genes).
        scores: scores of these genomes, (population,).
    """

    island: int
    first: int
    last: int
    genomes: Genomes
    scores: Scores


ParallelMap = Callable[
    [Callable[[Experiment, Epoch], list[EvaluatedPopulation]], Sequence[Epoch]],
    list[list[EvaluatedPopulation]],
]
"""Maps a function of an experiment and a task over tasks, as `Evaluator.map` does."""


def migrate(islands: Islands, genomes: Genomes, scores: Scores) -> tuple[Genomes, Scores]:
    """Replace the worst individuals of each island with copies of the best of its neighbours.

    Ties go to the first individual. All islands send before any island receives.

    Args:
        islands: topology and number of migrants.
        genomes: genomes of all islands, (islands, population, genes); not changed.
        scores: scores of these genomes, (islands, population).

    Returns:
        Genomes and scores after the migration.
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


def initial_islands(experiment: Experiment, space: GenomeSpace, starts: Genomes | None) -> Genomes:
    """Return generation 1 of all islands, (individuals, genes)."""
    islands = range(experiment.islands.number)
    return np.concatenate(
        [ask(experiment, space, {}, None, 1, island=one, starts=starts)[0] for one in islands]
    )


def next_islands(
    experiment: Experiment,
    space: GenomeSpace,
    genomes: Genomes,
    scores: Scores,
    number: int,
    record_parents: Callable[[Parents], object] | None = None,
) -> Genomes:
    """Return generation `number` of all islands, (individuals, genes), after a migration if due.

    Args:
        experiment: experiment with the search and the seed.
        space: genome space.
        genomes: genomes of the previous generation, (individuals, genes); not changed.
        scores: scores of these genomes, (individuals,).
        number: number of the generation to ask for, at least 2.
        record_parents: function that receives the parents, as rows of the previous generation of
            all islands, if the search names them.
    """
    epochs, recorded = _epochs(experiment, genomes, scores, number, number), list[Parents]()
    record = None if record_parents is None else recorded.append
    found = [
        _next_population(experiment, space, one.genomes, one.scores, number, one.island, record)
        for one in epochs
    ]
    if record_parents is not None and len(recorded) == len(epochs):
        rows = np.arange(len(genomes))[:, None]  # where each migrant comes from
        origins = [one.genomes[:, 0] for one in _epochs(experiment, rows, scores, number, number)]
        mapped = [
            np.where(parents < 0, -1, origin[parents])
            for origin, parents in zip(origins, recorded, strict=True)
        ]
        record_parents(np.concatenate(mapped))
    return np.concatenate(found)


def _next_population(
    experiment: Experiment,
    space: GenomeSpace,
    genomes: Genomes,
    scores: Scores,
    number: int,
    island: int,
    record_parents: Callable[[Parents], object] | None = None,
) -> Genomes:
    """Return the genomes of the next generation of one island, (population, genes)."""
    last = Results(genomes, scores)
    return ask(experiment, space, {}, last, number, island=island, record_parents=record_parents)[0]


def _epochs(
    experiment: Experiment, genomes: Genomes, scores: Scores, first: int, last: int
) -> list[Epoch]:
    """Return the epoch of each island, after the migration if one is due."""
    islands = experiment.islands
    populations = genomes.reshape(islands.number, -1, genomes.shape[1])
    values = scores.reshape(islands.number, -1)
    if (first - 1) % islands.every == 0:
        populations, values = migrate(islands, populations, values)
    return [
        Epoch(island, first, last, populations[island], values[island])
        for island in range(islands.number)
    ]


def evolve_epoch(experiment: Experiment, task: Epoch) -> list[EvaluatedPopulation]:
    """Evolve one island for an epoch; this function runs on a worker.

    Returns:
        The population and the evaluation of each generation.
    """
    space = experiment.space()
    populations: list[EvaluatedPopulation] = []
    genomes, scores = task.genomes, task.scores
    for number in range(task.first, task.last + 1):
        genomes = _next_population(experiment, space, genomes, scores, number, task.island)
        evaluation = evaluate(experiment, genomes, number)
        scores = evaluation.scores
        populations.append((genomes, evaluation))
    return populations


def island_map(evaluator: "Evaluator") -> ParallelMap | None:
    """Return the map that evolves islands on the evaluator's workers; None if it is not faster.

    With fewer islands than workers, or with threads, it is faster to evolve all islands in this
    process, generation by generation, and to let the workers evaluate individuals.
    """
    number = evaluator.experiment.islands.number
    faster = number > 1 and evaluator.remote and number >= evaluator.workers
    return evaluator.map if faster else None


def parallel_epoch(
    experiment: Experiment, parallel_map: ParallelMap, genomes: Genomes, scores: Scores, first: int
) -> list[EvaluatedPopulation]:
    """Evolve all islands from generation `first` to the next migration, one task per island.

    Returns:
        The genomes of all islands and their evaluation, for each generation.
    """
    every, planned = experiment.islands.every, experiment.evolution.generations
    last = min(-(-first // every) * every, max(planned, first))  # before the next migration
    tasks = _epochs(experiment, genomes, scores, first, last)
    return [
        (
            np.concatenate([population for population, _ in islands]),
            join_evaluations(experiment, [evaluation for _, evaluation in islands]),
        )
        for islands in zip(*parallel_map(evolve_epoch, tasks), strict=True)
    ]
