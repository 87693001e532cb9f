"""Training in stages: a search that goes on under a changed experiment."""

import math
from collections.abc import Callable
from dataclasses import replace

from gaitsim.contracts import Genomes
from gaitsim.evaluation import Evaluation
from gaitsim.evolution.generation import Generation, Progress
from gaitsim.experiment import Evolution


def stage_progress(
    before: Progress, evolution: Evolution, *, reevaluated: bool, population: int
) -> Progress:
    """Progress with which a stage begins.

    Where the scores are new ones, no best score and no threshold of the stage before can be
    compared with them: they begin anew, as in a run's first generation. The population
    was evaluated once more then, and that is counted.

    Args:
        before: progress at the end of the stage before.
        evolution: of the new stage.
        reevaluated: whether body or fitness was changed.
        population: individuals.
    """
    stage = before.stage + 1
    if not reevaluated:
        return replace(before, stage=stage)
    return Progress(
        evaluations=before.evaluations + population,
        best_score=-math.inf,
        stagnation=-1,
        threshold=evolution.fitness_threshold,
        stage=stage,
    )


def reevaluate(
    last: Generation, evaluate: Callable[[Genomes], Evaluation], progress: Progress
) -> Generation:
    """A generation judged anew, its genomes kept: what the next one is bred from.

    Args:
        last: the last generation of the stage before.
        evaluate: scores a population under the new stage's experiment.
        progress: with which the new stage begins.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract.
    """
    return replace(last, evaluation=evaluate(last.genomes), progress=progress)
