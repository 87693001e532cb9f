"""Breed the generations of a run again from the scores that it has recorded, without moving bodies.

A search is a function of its state and of scores, so every genome of every generation follows from
`scores.bin`. Only what `Evaluate` counts besides the populations is evaluated: at the start of a
stage and after worlds were redrawn, the genomes that the search remembers.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Parents
from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evolution import Generation
from gaitsim.evolution.loop import finish_generation, next_genomes
from gaitsim.evolution.searching import centre, pool_of, results
from gaitsim.experiment import Experiment
from gaitsim.storage.files.folder import ALL_SCORES, ONE_COPY
from gaitsim.storage.files.records import genomes_checksum
from gaitsim.storage.files.tables import damaged_error
from gaitsim.storage.stages import RunStage, begin_again


class RecordedRun(Protocol):
    """A run as far as it is read here; see `RunSnapshot`."""

    @property
    def path(self) -> Path: ...

    @property
    def stages(self) -> tuple[RunStage, ...]: ...
    @property
    def checksums(self) -> NDArray[Any]: ...
    def experiment_at(self, generation: int) -> Experiment: ...
    def starts(self, experiment: Experiment) -> Genomes | None: ...
    def scores(self, generation: int) -> NDArray[np.float64]: ...


@dataclass(frozen=True, eq=False)
class Bred:
    """A generation that was bred again.

    Attributes:
        generation: the generation; its evaluation has no terms.
        pool: genomes from which it was bred, (pool, genes): those that the search remembered, or
            the previous generation.
        parents: parents of the genomes, rows of the pool; None if the search names none.
        centre: genome amid those of the generation, (genes,); None for searches without one.
        kept: genomes that the search remembers now, or those of the generation, (kept, genes).
    """

    generation: Generation
    pool: Genomes
    parents: Parents | None
    centre: Genomes | None
    kept: Genomes


def breed_again(
    run: RecordedRun, until: int, advance: Callable[[int], object] = lambda generations: None
) -> Iterator[Bred]:
    """Yield the generations of a run up to `until`, bred from the recorded scores.

    Args:
        run: the run.
        until: number of the last generation.
        advance: called with 1 after each generation.

    Raises:
        RunError: genomes differ from the record, or the scores are missing or damaged.
    """
    last: Generation | None = None
    for stage in run.stages:
        if stage.first > until:
            return
        experiment = run.experiment_at(stage.last)
        space = experiment.space()
        with Evaluator(experiment) as evaluator:
            start = run.starts(experiment) if last is None else None
            if last is not None:
                last = begin_again(last, stage, experiment, evaluator.evaluate)
                last = replace(last, evaluation=replace(last.evaluation, terms={}))
            names: Sequence[str] = ()
            for number in range(stage.first, min(stage.last, until) + 1):
                parents: list[Parents] = []
                pool = _pool(experiment, last)
                genomes, state = next_genomes(experiment, space, last, start, parents.append)
                middle = centre(experiment, state)
                scores, *values = run.scores(number)
                if len(values) != len(names):
                    names = _names(run, evaluator, genomes, number, len(values))
                evaluation = Evaluation(scores, {}, {}, dict(zip(names, values, strict=True)))
                last = finish_generation(
                    experiment, space, last, state, genomes, evaluation, evaluator.evaluate, 0.0
                )
                recorded = run.checksums[number - 1 : number]["genomes"].tobytes()
                if recorded != genomes_checksum(genomes):
                    known = recorded.strip(b"\0")
                    what = "differs from the record when bred again" if known else "has no checksum"
                    raise RunError(
                        f"generation {number} {what}",
                        where=str(run.path),
                        remedy="use the versions and the machine that evolved it; 'gaitsim verify' "
                        "finds files that were changed",
                    )
                named, kept = parents[0] if parents else None, _pool(experiment, last)
                yield Bred(last, pool, named, middle, kept)
                advance(1)


def _pool(experiment: Experiment, last: Generation | None) -> Genomes:
    """Return the genomes from which the generation after `last` is bred."""
    if last is None:
        return experiment.space().no_genomes
    return pool_of(experiment, last.state, results(last.genomes, last.evaluation))


def _names(
    run: RecordedRun, evaluator: Evaluator, genomes: Genomes, number: int, count: int
) -> Sequence[str]:
    """Return the names of the values that the search reads, from one evaluation."""
    names = [*evaluator.evaluate(genomes[:1], number).values]
    if len(names) != count:
        what = f"generation {number} has {count} values of each individual, not {len(names)}"
        raise damaged_error(run.path / ALL_SCORES, what, ONE_COPY)
    return names
