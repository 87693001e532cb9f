"""Whether a run comes out the same again, to the last bit."""

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
"""How many generations are made again where none are asked for."""


@dataclass(frozen=True)
class Verdict:
    """What came of verifying a run.

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
    """See whether a run's files agree, then make generations again and compare them.

    Args:
        run: it; what a process adds to it meanwhile is left out.
        generations: which to make again; None for some.
        everything: evolve all of it again instead, up to the first difference.
        workers: how many work at a time; None for another number than is usual.
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
    found: Mapping[int, Sequence[str]] = disagreements(run)

    def judges(experiment: Experiment) -> Evaluator:
        return Evaluator(experiment, workers or unusual(experiment))

    begin(last if everything else len(asked))
    whole: list[int] = []
    best: list[int] = []
    if everything:
        for generation, wrong in reproduce_all(run, judges):
            whole.append(generation.number)
            advance()
            if wrong:
                found = _merged(found, generation.number, wrong)
                break
    else:
        for number, wholly, wrong in reproduce_some(run, asked, judges):
            (whole if wholly else best).append(number)
            advance()
            if wrong:
                found = _merged(found, number, wrong)
    origins = read_provenance(run.path)
    return Verdict(
        last=last,
        whole=tuple(whole),
        best=tuple(best),
        differences=found,
        without_checksum=without_checksum(run),
        warning=run.warning,
        damaged=run.damaged,
        asked=edited_options(run),
        origins=tuple(origins),
        elsewhere=tuple(differences(origins, current_versions(run.experiment_at(last)))),
    )


def unusual(experiment: Experiment) -> int:
    """Return a number of workers that differs from the default of a run."""
    return 1 if experiment.organism.threads else 2


def _merged(
    found: Mapping[int, Sequence[str]], number: int, wrong: Sequence[str]
) -> dict[int, Sequence[str]]:
    both = {**found, number: [*found.get(number, ()), *wrong]}
    return dict(sorted(both.items()))
