"""The evolution loop, as an iterator.

    state ─▶ ask ─▶ evaluate ─▶ tell ─▶ Generation 1 ─▶ ask ─▶ evaluate ─▶ tell ─▶ Generation 2 …
                                            │
                                            └─▶ the caller saves it, shows it, or stops

Nothing is pending between two generations. A caller that stops iterating loses nothing, and
resuming from a `Generation` yields the same later generations.

If the worlds are redrawn before a generation, its scores cannot be compared with earlier ones. The
best score is then reset, and the genomes that the search remembers are re-evaluated before `tell`.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, GenomeSpace, Parents, State
from gaitsim.evaluation import Evaluation
from gaitsim.evaluation.scoring import Evaluate, check_terms
from gaitsim.evolution.islands import (
    EvaluatedPopulation,
    ParallelMap,
    initial_islands,
    next_islands,
    parallel_epoch,
)
from gaitsim.evolution.searching import (
    ask,
    figures,
    finished,
    initial_state,
    reevaluate_remembered,
    results,
    tell,
)
from gaitsim.experiment import Evolution, Experiment
from gaitsim.registry import plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.stopping import SearchProgress, stop_reason


@dataclass(frozen=True, eq=False, repr=False)
class Generation(ReprMixin):
    """One evaluated generation; its arrays are frozen as well.

    Attributes:
        number: number of the generation, counted from 1.
        genomes: genomes of the population, (population, genes).
        evaluation: scores of the genomes, their terms, and reasons for failures.
        progress: progress of the search, including this generation.
        diversity: diversity of the genomes, as their space defines it.
        seconds: time that `ask` and the evaluation took.
        is_champion: whether the best individual beat the threshold.
        stop: reason why the search ends after this generation; '' if it continues.
        state: state of the search after `tell`.
        figures: numbers about the search by name; see `Search.figures`.
    """

    number: int
    genomes: Genomes
    evaluation: Evaluation
    progress: SearchProgress
    diversity: float
    seconds: float
    is_champion: bool
    stop: str
    state: State = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for values in (self.genomes, self.scores, *self.evaluation.terms.values()):
            values.setflags(write=False)

    @property
    def scores(self) -> NDArray[np.float64]:
        """The scores, (population,); higher is better."""
        return self.evaluation.scores

    @property
    def best(self) -> int:
        """Index of the best individual; ties go to the first."""
        return int(np.argmax(self.scores))

    def _repr_fields(self) -> Mapping[str, ReprField]:
        best, finite = self.best, self.scores[np.isfinite(self.scores)]
        failed = len(self.scores) - len(finite)
        return {
            "number": self.number,
            "best": float(self.scores[best]),
            "mean": float(finite.mean()) if len(finite) else "",
            "diversity": self.diversity,
            "failed": failed or "",
            "terms of the best": self.evaluation.terms_of(best),
            "stop": self.stop,
        }


def evolve(
    experiment: Experiment,
    evaluate: Evaluate,
    after: Generation | None = None,
    starts: Genomes | None = None,
    parallel_map: ParallelMap | None = None,
) -> Iterator[Generation]:
    """Evolve generation after generation until a stop condition holds.

    Args:
        experiment: experiment to evolve.
        evaluate: function that scores a population in the worlds of a generation.
        after: generation to continue from; None starts with the first.
        starts: genomes around which the first generation is drawn, (starts, genes), in place of
            those that the option `search.start` chooses.
        parallel_map: function that evolves islands on workers, from one migration to the next; None
            evolves all islands in this process, generation by generation. The result is the same.

    Yields:
        Each finished generation; `stop` of the last one holds the reason for the end.

    Raises:
        PluginError: a plugin fails or breaks its contract; the error names its package.
    """
    space, evolution = experiment.space(), experiment.evolution
    while after is None or not stop_reason(
        evolution, after.number, after.progress, len(after.genomes)
    ):
        start = time.perf_counter()
        state, evaluated = _next_generations(
            experiment, space, evaluate, after, starts, parallel_map
        )
        seconds = (time.perf_counter() - start) / len(evaluated)
        for genomes, evaluation in evaluated:
            after = finish_generation(
                experiment, space, after, state, genomes, evaluation, evaluate, seconds
            )
            state = after.state
            yield after
            if after.stop:
                return


def finish_generation(
    experiment: Experiment,
    space: GenomeSpace,
    after: Generation | None,
    state: State,
    genomes: Genomes,
    evaluation: Evaluation,
    evaluate: Evaluate,
    seconds: float,
) -> Generation:
    """Tell the search the scores of its genomes, and return the finished generation.

    Args:
        experiment: experiment with the search.
        space: genome space.
        after: previous generation; None for the first.
        state: state that the search returned with the genomes.
        genomes: genomes of the population, (population, genes).
        evaluation: scores of the genomes.
        evaluate: function that scores the genomes that the search remembers in new worlds.
        seconds: time that `ask` and the evaluation took.
    """
    start, evolution = time.perf_counter(), experiment.evolution
    number, before = 1, SearchProgress(0, -math.inf, -1, evolution.fitness_threshold)
    if after is not None:
        number, before = after.number + 1, after.progress
        check_terms(experiment, after.evaluation, evaluation)
    if experiment.worlds.redrawn(number):
        state, more = reevaluate_remembered(experiment, state, evaluate, number, redrawn=True)
        before = before.reset_scores(evolution.fitness_threshold, more)
    state = tell(experiment, space, state, results(genomes, evaluation), number)
    with plugin_errors(experiment.entries["organism"], "measuring diversity"):
        diversity = float(space.diversity(genomes))
    progress, is_champion = advance(before, float(evaluation.scores.max()), len(genomes), evolution)
    progress = replace(progress, finished=finished(experiment, state))
    return Generation(
        number=number,
        genomes=genomes,
        evaluation=evaluation,
        progress=progress,
        diversity=diversity,
        seconds=seconds + time.perf_counter() - start,
        is_champion=is_champion,
        stop=stop_reason(evolution, number, progress, len(genomes)),
        state=state,
        figures=figures(experiment, state),
    )


def _next_generations(
    experiment: Experiment,
    space: GenomeSpace,
    evaluate: Evaluate,
    after: Generation | None,
    starts: Genomes | None,
    parallel_map: ParallelMap | None,
) -> tuple[State, list[EvaluatedPopulation]]:
    """Return the state before `tell`, and one or more evaluated generations.

    With `parallel_map`, these are all generations up to the next migration.
    """
    number = after.number + 1 if after else 1
    if experiment.islands.number > 1 and after is not None and parallel_map is not None:
        return {}, parallel_epoch(experiment, parallel_map, after.genomes, after.scores, number)
    genomes, state = next_genomes(experiment, space, after, starts)
    return state, [(genomes, evaluate(genomes, number))]


def next_genomes(
    experiment: Experiment,
    space: GenomeSpace,
    after: Generation | None,
    starts: Genomes | None,
    record_parents: Callable[[Parents], object] | None = None,
) -> tuple[Genomes, State]:
    """Return the genomes of the next generation, and the state to pass to `finish_generation`."""
    number = after.number + 1 if after else 1
    if experiment.islands.number > 1:  # only searches with an empty state support islands
        if after is None:
            return initial_islands(experiment, space, starts), {}
        return next_islands(
            experiment, space, after.genomes, after.scores, number, record_parents
        ), {}
    if after is None:
        state = initial_state(experiment, space, starts)
        return ask(experiment, space, state, None, 1, starts=starts)
    last = results(after.genomes, after.evaluation)
    return ask(experiment, space, after.state, last, number, record_parents=record_parents)


def reevaluate(experiment: Experiment, last: Generation, evaluate: Evaluate) -> Generation:
    """Return a generation with new scores for the same genomes, to continue from.

    The genomes whose scores the search remembers are also re-evaluated, and count as evaluations.

    Args:
        experiment: experiment of the next stage.
        last: last generation, with the progress of the next stage.
        evaluate: function that scores a population under that experiment.

    Raises:
        PluginError: a plugin fails or breaks its contract; the error names its package.
    """
    state, more = reevaluate_remembered(experiment, last.state, evaluate, last.number)
    progress = replace(last.progress, evaluations=last.progress.evaluations + more)
    return replace(
        last, evaluation=evaluate(last.genomes, last.number), state=state, progress=progress
    )


def advance(
    before: SearchProgress, best: float, evaluated: int, evolution: Evolution
) -> tuple[SearchProgress, bool]:
    """Return the progress after a generation, and whether its best individual is a champion.

    The score of a champion exceeds the threshold. The threshold then rises in whole steps of
    `delta_fitness` until it is no longer below that score.
    """
    threshold = before.threshold
    is_champion = threshold is not None and best > threshold
    if threshold is not None and is_champion:
        threshold = _raise_threshold(threshold, best, evolution.delta_fitness)
    rose = best > before.best_score
    progress = SearchProgress(
        evaluations=before.evaluations + evaluated,
        best_score=max(best, before.best_score),
        stagnation=0 if rose else before.stagnation + 1,
        threshold=threshold,
        stage=before.stage,
    )
    return progress, is_champion


def _raise_threshold(threshold: float, best: float, step: float) -> float:
    """Return the threshold raised in whole steps to `best` or just above."""
    steps = (best - threshold) / step
    raised = threshold + step * math.ceil(steps) if math.isfinite(steps) else best
    # If rounding left the threshold below, the same individual would be a champion twice.
    return raised if best <= raised < math.inf else best
