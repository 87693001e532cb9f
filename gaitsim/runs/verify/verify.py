"""Verify that a run can be reproduced to the last bit."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluator
from gaitsim.experiment import Experiment
from gaitsim.runs.files.provenance import Provenance, current_versions, differences, read_provenance
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.stages import Change
from gaitsim.runs.verify.consistency import disagreements, edited_options, without_checksum
from gaitsim.runs.verify.reproduce import reproduce_all, reproduce_some

SAMPLES = 10
"""Number of generations that are reproduced by default."""


@dataclass(frozen=True)
class Verdict:
    """The result of verifying a run.

    Attributes:
        last: the run's last generation.
        whole: the generations that were fully reproduced.
        best: those of which the best individual was re-evaluated.
        differences: what is not as recorded, by generation in order; {} where all is identical.
        without_checksum: how many generations have no checksum to be compared with.
        warning: what a user should know about how the run was found, or ''.
        damaged: checkpoints that cannot be read, a text each: which, and why.
        asked: the options of `experiment.toml`, the end of the search aside, that are not those
            that the last generation was made with.
        origins: what the run was made with; () where it does not say.
        elsewhere: where that differs from what is here, a text each.
    """

    last: int
    whole: tuple[int, ...]
    best: tuple[int, ...]
    differences: Mapping[int, Sequence[str]]
    without_checksum: int
    warning: str
    damaged: tuple[str, ...]
    asked: tuple[Change, ...]
    origins: tuple[Provenance, ...]
    elsewhere: tuple[str, ...]

    @property
    def identical(self) -> bool:
        """Whether nothing differs: no generation, no checkpoint, no option in the file."""
        return not (self.differences or self.damaged or self.asked)

    @property
    def not_reproduced(self) -> tuple[tuple[int, int], ...]:
        """The generations of which only the files were compared: first and last of each span."""
        done = sorted({*self.whole, *self.best})
        gaps = zip([0, *done], [*done, self.last + 1], strict=True)
        return tuple((before + 1, after - 1) for before, after in gaps if after - before > 1)


def sample(last: int, count: int = SAMPLES) -> list[int]:
    """Generations spread evenly from the first to the last one."""
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
    """Check that a run's files agree, then reproduce generations and compare them.

    Args:
        run: the run; generations that a process adds meanwhile are left out.
        generations: which to reproduce; None for a sample.
        everything: evolve the whole run again instead, up to the first difference.
        workers: how many work at a time; None for another number than the default.
        begin: called with the number of generations to reproduce.
        advance: called after each one.

    Raises:
        RunError: the run is damaged beyond comparing, has no generation yet, or not one that is
            asked for.
        ExperimentError: its experiment has problems, such as a plugin that is not installed.
        PluginError: a plugin fails.
    """
    last = run.finished.generation
    _ = run.previous  # now, before the run grows
    asked = sorted({*generations}) if generations else sample(last)
    for number in (asked[0], asked[-1]):
        if not 1 <= number <= last:
            raise RunError(
                f"the run {run.path} has no generation {number}",
                where="--generations",
                allowed=f"1 to {last}",
            )
    found = disagreements(run)

    def judges(experiment: Experiment) -> Evaluator:
        # Another number of workers than the run's default: the result must not depend on it.
        return Evaluator(experiment, workers or (1 if experiment.organism.threads else 2))

    begin(last if everything else len(asked))
    reproduced: dict[bool, list[int]] = {True: [], False: []}
    again = reproduce_all(run, judges) if everything else reproduce_some(run, asked, judges)
    for number, wholly, wrong in again:
        reproduced[wholly].append(number)
        advance()
        if wrong:
            found.setdefault(number, []).extend(wrong)
            if everything:
                break
    origins = read_provenance(run.path)
    return Verdict(
        last=last,
        whole=tuple(reproduced[True]),
        best=tuple(reproduced[False]),
        differences=dict(sorted(found.items())),
        without_checksum=without_checksum(run),
        warning=run.warning,
        damaged=run.damaged,
        asked=edited_options(run),
        origins=tuple(origins),
        elsewhere=tuple(differences(origins, current_versions(run.experiment_at(last)))),
    )
