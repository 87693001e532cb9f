"""Verify that a run can be reproduced bit for bit."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluator
from gaitsim.experiment import Experiment
from gaitsim.runs.files.provenance import Provenance, current_versions, differences, read_provenance
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.stages import Change
from gaitsim.runs.verify.consistency import count_without_checksum, edited_options, inconsistencies
from gaitsim.runs.verify.reproduce import reproduce_all, reproduce_some

SAMPLES = 10
"""Number of generations that are reproduced by default."""


@dataclass(frozen=True)
class Verdict:
    """The result of verifying a run.

    Attributes:
        last: last generation of the run.
        reproduced: generations that were fully reproduced.
        best_only: generations whose best individual was re-evaluated.
        differences: differences from the record, by generation in order; {} if all is identical.
        without_checksum: number of generations without a checksum.
        warning: warning about the files of the run, or ''.
        damaged: one message for each checkpoint that cannot be read.
        edited: options of `experiment.toml` that differ from those of the last generation, except
            for those that only affect when the search stops.
        origins: versions and processors that computed the run; () if not recorded.
        version_differences: one message for each difference between `origins` and the current
            versions.
        portability: class of the results and its meaning; see `Experiment.portability`.
        score_difference: largest distance of a reproduced generation's best score from the
            recorded one.
    """

    last: int
    reproduced: tuple[int, ...]
    best_only: tuple[int, ...]
    differences: Mapping[int, Sequence[str]]
    without_checksum: int
    warning: str
    damaged: tuple[str, ...]
    edited: tuple[Change, ...]
    origins: tuple[Provenance, ...]
    version_differences: tuple[str, ...]
    portability: str
    score_difference: float

    @property
    def identical(self) -> bool:
        """Whether all generations and options are identical, and all checkpoints intact."""
        return not (self.differences or self.damaged or self.edited)

    @property
    def not_reproduced(self) -> tuple[tuple[int, int], ...]:
        """The first and last generation of each span in which only the files were checked."""
        done = sorted({*self.reproduced, *self.best_only})
        gaps = zip([0, *done], [*done, self.last + 1], strict=True)
        return tuple((before + 1, after - 1) for before, after in gaps if after - before > 1)


def sample(last: int, count: int = SAMPLES) -> list[int]:
    """Return generations spread evenly from the first to the last."""
    return sorted({int(number) for number in np.linspace(1, last, min(count, last)).round()})


def verify(
    run: RunSnapshot,
    generations: Sequence[int] | None = None,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[], None] = lambda: None,
) -> Verdict:
    """Check that a run's files are consistent, then reproduce generations and compare them.

    Args:
        run: run to verify; generations added during the verification are left out.
        generations: generations to reproduce; None for a sample.
        everything: whether to reproduce the whole run instead, up to the first difference.
        workers: number of parallel workers; None for a number that deliberately differs from the
            run's default, as the result must not depend on it.
        begin: callback with the number of generations to reproduce.
        advance: callback after each generation.
    """
    last = run.finished.generation
    _ = run.previous  # read and cached now, before the run grows
    requested = sorted({*generations}) if generations else sample(last)
    for number in (requested[0], requested[-1]):
        if not 1 <= number <= last:
            raise RunError(
                f"the run {run.path} has no generation {number}",
                where="--generations",
                allowed=f"1 to {last}",
            )
    found = inconsistencies(run)

    def new_evaluator(experiment: Experiment) -> Evaluator:
        # Not the run's default number of workers, as the result must not depend on it.
        return Evaluator(experiment, workers or (1 if experiment.organism.threads else 2))

    begin(last if everything else len(requested))
    reproduced: dict[bool, list[int]] = {True: [], False: []}
    results = (
        reproduce_all(run, new_evaluator)
        if everything
        else reproduce_some(run, requested, new_evaluator)
    )
    farthest = 0.0
    for again in results:
        reproduced[again.fully].append(again.number)
        farthest = max(farthest, again.score_difference)
        advance()
        if again.differences:
            found.setdefault(again.number, []).extend(again.differences)
            if everything:
                break
    origins = read_provenance(run.path)
    return Verdict(
        last=last,
        reproduced=tuple(reproduced[True]),
        best_only=tuple(reproduced[False]),
        differences=dict(sorted(found.items())),
        without_checksum=count_without_checksum(run),
        warning=run.warning,
        damaged=run.damaged,
        edited=edited_options(run),
        origins=tuple(origins),
        version_differences=tuple(differences(origins, current_versions(run.experiment_at(last)))),
        portability=run.portability,
        score_difference=farthest,
    )
