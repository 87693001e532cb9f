"""The map of an atlas: how each of its gaits behaves, and how it performs on the intact body."""

import hashlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from gaitsim.adaptation.intact import read_intact, write_intact
from gaitsim.adaptation.performance import MEASURE, Floats, performance, unit_of
from gaitsim.contracts import Genomes, Members
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.evaluator import IN_CACHE
from gaitsim.evaluation.processes import OnWarning
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual, Member
from gaitsim.runs.compatibility import ENGINES, versions
from gaitsim.runs.files.folder import command
from gaitsim.runs.snapshot import RunSnapshot

_BETWEEN = 0.2  # seconds from one report of the progress to the next, at least

OnProgress = Callable[[int], None]
"""Called with the number of gaits that were evaluated since the last call."""


@dataclass(frozen=True, eq=False)
class Prior:
    """The gaits of an atlas, with what is expected of them before any is tried.

    Attributes:
        experiment: of the intact body.
        source: the run's folder.
        generation: of the archive.
        measure: name of the measure that is the performance; more is better.
        unit: of that measure.
        genomes: (members, genes).
        scores: of the members in the search, (members,).
        axes: names of the axes of the archive.
        behaviour: the axes in shares of their ranges, (members, axes).
        performance: on the intact body, (members,); 0 for a gait that fails.
    """

    experiment: Experiment
    source: Path
    generation: int
    measure: str
    unit: str
    genomes: Genomes
    scores: Floats
    axes: tuple[str, ...]
    behaviour: Floats
    performance: Floats

    @property
    def best(self) -> float:
        """The best performance on the intact body, above 0."""
        return float(self.performance.max())

    def individual(self, member: int) -> Individual:
        """Return the gait of a member, by its number from 1, on the intact body; without terms."""
        index = member - 1
        return Individual(
            self.experiment,
            float(self.scores[index]),
            {},
            self.generation,
            self.genomes[index],
            self.source,
            member=Member(member),
        )


def read_prior(
    run: RunSnapshot,
    measure: str = MEASURE,
    *,
    workers: int | None = None,
    on_progress: OnProgress = lambda done: None,
    on_warning: OnWarning = lambda text: None,
) -> Prior:
    """Evaluate all members of an atlas on the intact body.

    The run's folder keeps the result, by which the next call needs no evaluation.

    Args:
        run: of a search that keeps an archive.
        measure: name of the measure that is the performance.
        workers: how many work at a time; None for what suits the body. Does not change the result.
        on_progress: called with the number of gaits that were evaluated since the last call.
        on_warning: called with a message for the user.

    Raises:
        GaitsimError: the body has no such measure, or no gait has a performance above 0.
        PluginError: the body fails or breaks its contract.
        RunError: the run is not an atlas, or has no members.
    """
    members = atlas_members(run)
    experiment, genomes = run.experiment_at(run.generation), members.genomes
    unit = unit_of(experiment, genomes, measure)
    key = _key(run, members, measure)
    performed = read_intact(run.path, measure, key, len(genomes))
    if performed is None:
        with Evaluator(experiment, workers, on_warning) as evaluator:
            performed = _evaluated(evaluator, genomes, measure, on_progress)
        write_intact(run.path, measure, key, performed)
    else:
        on_progress(len(genomes))
    if not performed.max() > 0:
        raise GaitsimError(
            f"no gait of the atlas {run.path} has a measure {measure!r} above 0",
            allowed="a measure of which more is better",
            remedy=f"choose another measure, or continue the atlas: {command('resume', run.path)}",
        )
    return Prior(
        experiment,
        run.path,
        run.generation,
        measure,
        unit,
        genomes,
        members.scores,
        tuple(members.values),
        _shares(members),
        performed,
    )


def _key(run: RunSnapshot, members: Members, measure: str) -> str:
    """Return all that the performance of the members depends on."""
    experiment = run.experiment_at(run.generation)
    # The versions are complete once a gait was moved, as an engine is loaded then.
    known = versions(experiment)
    if not experiment.organism.dynamic:  # an engine moves another body of this process
        known = {name: version for name, version in known.items() if name not in ENGINES}
    parts = (measure, checksum_of(members), run.finished.experiment, sorted(known.items()))
    return "\n".join(map(str, parts))


def _evaluated(
    evaluator: Evaluator, genomes: Genomes, measure: str, on_progress: OnProgress
) -> Floats:
    found: list[Floats] = []
    first, size = 0, evaluator.workers
    while first < len(genomes):
        some = genomes[first : first + size]
        parts = max(min(evaluator.workers, len(some)), math.ceil(len(some) / IN_CACHE))
        start = time.perf_counter()
        found += evaluator.map(partial(performance, measure=measure), np.array_split(some, parts))
        first += len(some)
        on_progress(len(some))
        if time.perf_counter() - start < _BETWEEN:
            size *= 2
    return np.concatenate(found)


def atlas_members(run: RunSnapshot) -> Members:
    """Return the members of an atlas.

    Raises:
        RunError: the run is not an atlas, or has no members.
    """
    if run.experiment.search.keeps != "archive":
        raise RunError(
            f"the run {run.path} is not an atlas: its search keeps no archive",
            allowed="a run of the search map-elites",
            remedy=f"evolve an atlas: {command('atlas', 'spider')}",
        )
    members = run.members
    if members is None or not len(members.scores):
        raise RunError(
            f"the atlas {run.path} is empty: every individual failed",
            remedy=f"see why: {command('show', run.path)}",
        )
    return members


def checksum_of(members: Members) -> str:
    """Return the SHA-256 of the genomes and the behaviour of the members of an atlas."""
    digest = hashlib.sha256(np.ascontiguousarray(members.genomes).tobytes())
    digest.update("\0".join(members.values).encode())
    digest.update(np.ascontiguousarray(_shares(members)).tobytes())
    return digest.hexdigest()


def _shares(members: Members) -> Floats:
    ends = {name: (borders[0], borders[-1]) for name, borders in (members.borders or {}).items()}
    shares = [
        (values - ends[name][0]) / (ends[name][1] - ends[name][0])
        for name, values in members.values.items()
    ]
    # Cells at the border hold the values beyond it, too.
    return np.asarray(np.clip(np.stack(shares, axis=1), 0.0, 1.0))
