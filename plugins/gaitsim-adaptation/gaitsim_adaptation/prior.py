"""The map of an atlas: the behaviour of each gait, and its performance on the intact body."""

import hashlib
import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    GaitsimError,
    Genomes,
    Measure,
    Members,
    Motion,
    RunError,
    plugin_errors,
    read_regular,
    unknown,
)
from gaitsim.plugin.gait import damage_body
from gaitsim.plugin.runs import (
    ADAPTATIONS,
    IN_CACHE,
    Evaluator,
    Experiment,
    Individual,
    Member,
    OnWarning,
    RunSnapshot,
    command,
    create_subfolder,
    move_genomes,
    values_of,
    versions,
    write_bytes,
)

DEFAULT_MEASURE = "forward"
Floats = NDArray[np.float64]


def performance(experiment: Experiment, genomes: Genomes, measure: str) -> Floats:
    """Simulate genomes, (population, genes), and return their performance, (population,).

    The performance is the measure of a gait, or 0 if the gait fails or the measure is not finite.
    """
    return performance_of(experiment, move_genomes(experiment, genomes), measure)


def performance_of(experiment: Experiment, motion: Motion, measure: str) -> Floats:
    """Return the performance of the gaits in a motion, (population,); see `performance`."""
    known = _measures(experiment, motion, measure)
    values = values_of(experiment.entries["organism"], known, measure, motion.population)
    values[list(motion.failures)] = 0.0
    return np.where(np.isfinite(values), values, 0.0)


def unit_of(experiment: Experiment, genomes: Genomes, measure: str) -> str:
    """Return the unit of a measure; simulates one genome."""
    return str(_measures(experiment, move_genomes(experiment, genomes[:1]), measure)[measure].unit)


def _measures(experiment: Experiment, motion: Motion, measure: str) -> Mapping[str, Measure]:
    """Return the measures of a motion, after checking that they include `measure`."""
    body = experiment.entries["organism"]
    with plugin_errors(body, "measuring a population"):
        known: Mapping[str, Measure] = experiment.organism.measures(motion)
    if measure not in known:
        raise unknown("measure", measure, known, where=str(body))
    return known


_DIGEST = hashlib.sha256().digest_size


def read_intact(run: Path, measure: str, key: str, members: int) -> Floats | None:
    """Return the cached performance of each member, (members,); None if it is not cached.

    Args:
        run: folder of the atlas.
        measure: name of the performance measure.
        key: string that identifies everything on which the performance depends.
        members: number of members.
    """
    try:
        data = read_regular(intact_file(run, measure), _DIGEST + 8 * members)
    except OSError:
        return None
    digest, content = data[:_DIGEST], data[_DIGEST:]
    if len(content) != 8 * members or digest != _digest(key, content):
        return None
    found = np.frombuffer(content, "<f8").astype(np.float64)
    return found if np.isfinite(found).all() else None


def write_intact(run: Path, measure: str, key: str, performance: Floats) -> None:
    """Cache the performance of each member; do nothing if the folder cannot be written."""
    content = performance.astype("<f8").tobytes()
    with suppress(RunError):
        create_subfolder(run, ADAPTATIONS)
        write_bytes(intact_file(run, measure), _digest(key, content) + content, follow=False)


def intact_file(run: Path, measure: str) -> Path:
    """Return the file that caches the performance of each member."""
    return run / ADAPTATIONS / f"intact-{re.sub(r'[^a-zA-Z0-9]+', '-', measure)[:80]}.bin"


def _digest(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + content).digest()


_PROGRESS_INTERVAL = 0.2  # s, shortest time between reports of progress

OnProgress = Callable[[int], None]
"""Called with the number of gaits evaluated since the last call."""


@dataclass(frozen=True, eq=False)
class Prior:
    """The gaits of an atlas, with their expected performance before any trial.

    Attributes:
        experiment: experiment with the intact body.
        source: folder of the run.
        generation: generation of the archive.
        measure: name of the performance measure, where more is better.
        unit: unit of that measure.
        genomes: genomes of the members, (members, genes).
        scores: scores of the members in the search, (members,).
        axes: names of the axes of the archive.
        behaviour: values on the axes, scaled to 0 to 1 over their ranges, (members, axes).
        performance: performance on the intact body, (members,); 0 for a gait that fails.
        damaged: performance on the body with the damage that is known, (members,); None if no
            damage is known.
        damage: the damage that is known.
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
    damaged: Floats | None = None
    damage: tuple[str, ...] = ()

    @property
    def best(self) -> float:
        """Best performance on the intact body, above 0."""
        return float(self.performance.max())

    def simulate(self, genomes: Genomes) -> Floats:
        """Return the mean performance on the intact body and that with the known damage.

        It is 0 in rigid-body physics, where simulations take too long, (genomes,).
        """
        if self.experiment.organism.dynamic:
            return np.zeros(len(genomes))
        bodies = [self.experiment]
        if self.damage:
            bodies.append(damage_body(self.experiment, self.damage))
        values = (performance(body, genomes, self.measure) for body in bodies)
        return np.asarray(sum(values) / len(bodies))

    def individual(self, member: int) -> Individual:
        """Return the gait of a member, counted from 1, on the intact body; it has no terms."""
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
    measure: str = DEFAULT_MEASURE,
    damage: Sequence[str] = (),
    *,
    cached: bool = True,
    workers: int | None = None,
    on_progress: OnProgress = lambda done: None,
    on_warning: OnWarning = lambda text: None,
) -> Prior:
    """Evaluate all members of an atlas on the intact body.

    Args:
        run: run of a search that keeps an archive.
        measure: name of the performance measure.
        damage: damage that is known; all members are also evaluated on this body.
        cached: whether to read and write a file in the run's folder, so that later calls need not
            evaluate the members.
        workers: number of workers, which does not change the result; None for a number that suits
            the body.
        on_progress: called with the number of gaits evaluated since the last call.
        on_warning: called with a message for the user.
    """
    members = atlas_members(run)
    experiment, genomes = run.experiment_at(run.generation), members.genomes
    if Individual(experiment, 0.0, {}, genome=genomes[0]).body is not experiment.organism:
        raise GaitsimError(
            f"the gaits of the atlas {run.path} have bodies of their own, but one body adapts",
            allowed="an atlas whose dimensions do not evolve",
            remedy="set organism.dimensions instead of organism.evolve",
        )
    unit = unit_of(experiment, genomes, measure)

    def evaluated(body: Experiment, name: str) -> Floats:
        key = cache_key(run, measure, body)
        found = read_intact(run.path, name, key, len(genomes)) if cached else None
        if found is None:
            with Evaluator(body, workers, on_warning) as evaluator:
                found = _evaluate_map(evaluator, genomes, measure, on_progress)
            if cached:
                write_intact(run.path, name, key, found)
        elif body is experiment:
            on_progress(len(genomes))
        return found

    performed = evaluated(experiment, measure)
    if not performed.max() > 0:
        raise GaitsimError(
            f"the measure {measure!r} is not above 0 for any gait of the atlas {run.path}",
            allowed="a measure that is above 0 for at least one gait, where more is better",
            remedy=f"choose another measure, or evolve the atlas further: "
            f"{command('resume', run.path)}",
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
        _behaviour(members),
        performed,
        evaluated(damage_body(experiment, damage), _damaged_name(measure, damage))
        if damage
        else None,
        tuple(damage),
    )


FEW_GAITS = 100
SHORT = 0.1  # m; a body that walks less far in the map hardly walks


def poverty(prior: Prior) -> str:
    """Return a warning that a map is too poor to help, or ''."""
    count, best = len(prior.performance), prior.best
    slow = prior.unit == "m" and best < SHORT
    if count >= FEW_GAITS and not slow:
        return ""
    walked = f", the best of which has {prior.measure} {best:.3g} {prior.unit}".rstrip()
    return (
        f"The atlas has {count:,} gaits{walked}: too few or too slow to adapt well. Evolve it "
        f"further: {command('resume', prior.source, '--generations')} N"
    )


def _damaged_name(measure: str, damage: Sequence[str]) -> str:
    """Return the name under which the performance on a body with known damage is cached."""
    return f"{measure} {tuple(damage)}"


def intact_differences(run: RunSnapshot, prior: Prior, damage: Sequence[str] = ()) -> list[str]:
    """Return how cached performance of members differs from that of `read_prior`."""
    maps = {prior.measure: (prior.experiment, prior.performance)}
    if prior.damaged is not None:
        body = damage_body(prior.experiment, damage)
        maps[_damaged_name(prior.measure, damage)] = body, prior.damaged
    found = []
    for name, (body, performed) in maps.items():
        key = cache_key(run, prior.measure, body)
        cached = read_intact(run.path, name, key, len(performed))
        if cached is not None and (cached != performed).any():
            wrong = int(np.flatnonzero(cached != performed)[0]) + 1
            found.append(f"{intact_file(run.path, name).name}: member {wrong} differs")
    return found


def cache_key(run: RunSnapshot, measure: str, experiment: Experiment) -> str:
    """Return a string that identifies everything on which the members' performance depends.

    Args:
        run: run of the atlas.
        measure: name of the performance measure.
        experiment: experiment with the body that is measured.
    """
    # The versions are complete only after a gait has been simulated, as that loads the engine.
    known = versions(experiment)
    atlas, body = atlas_checksum(atlas_members(run)), experiment.to_toml()
    parts = (measure, atlas, run.finished.experiment, body, sorted(known.items()))
    return "\n".join(map(str, parts))


def _evaluate_map(
    evaluator: Evaluator, genomes: Genomes, measure: str, on_progress: OnProgress
) -> Floats:
    found: list[Floats] = []
    first, size = 0, evaluator.workers
    while first < len(genomes):
        batch = genomes[first : first + size]
        chunks = max(min(evaluator.workers, len(batch)), math.ceil(len(batch) / IN_CACHE))
        start = time.perf_counter()
        found += evaluator.map(partial(performance, measure=measure), np.array_split(batch, chunks))
        first += len(batch)
        on_progress(len(batch))
        if time.perf_counter() - start < _PROGRESS_INTERVAL:
            size *= 2
    return np.concatenate(found)


def atlas_members(run: RunSnapshot) -> Members:
    """Return the members of an atlas."""
    if run.experiment.search.keeps != "archive":
        raise RunError(
            f"the run {run.path} is not an atlas: its search keeps no archive",
            allowed="a run of the search 'map-elites'",
            remedy=f"evolve an atlas: {command('atlas', 'spider')}",
        )
    members = run.members
    if members is None or not len(members.scores):
        raise RunError(
            f"the atlas {run.path} is empty: every individual failed",
            remedy=f"see why: {command('show', run.path)}",
        )
    return members


def atlas_checksum(members: Members) -> str:
    """Return the SHA-256 hash of the genomes and the behaviour of the members of an atlas."""
    digest = hashlib.sha256(np.ascontiguousarray(members.genomes).tobytes())
    digest.update("\0".join(members.values).encode())
    digest.update(np.ascontiguousarray(_behaviour(members)).tobytes())
    return digest.hexdigest()


def _behaviour(members: Members) -> Floats:
    """Return the values on the axes, scaled to 0 to 1 over their ranges, (members, axes)."""
    ends = {name: (borders[0], borders[-1]) for name, borders in (members.borders or {}).items()}
    scaled = [
        (values - ends[name][0]) / (ends[name][1] - ends[name][0])
        for name, values in members.values.items()
    ]
    # Cells at the border also contain values beyond the range.
    return np.asarray(np.clip(np.stack(scaled, axis=1), 0.0, 1.0))
