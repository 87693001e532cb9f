"""The gaits of many individuals of one body: their names, duty factors and stride frequencies."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gaitsim.contracts import Genomes, Motion
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.scoring import move_genomes
from gaitsim.experiment import Experiment
from gaitsim.gait.feet import Floats, body_order, feet_of_each, phases_of
from gaitsim.gait.naming import NONE, Name, name_of
from gaitsim.gait.report import commands_frequency, relative_feet, stands
from gaitsim.gait.travel import frames_in
from gaitsim.legged.stepping import STRIDE_FREQUENCY
from gaitsim.registry import plugin_errors

_SAMPLES = 9  # number of individuals whose skeletons give the layout of the feet
_CHUNK = 50  # individuals per chunk; each worker holds their motions in memory


@dataclass(frozen=True)
class RepertoireGait:
    """The gait of one individual.

    Attributes:
        name: name of the gait.
        duty_factor: mean duty factor of the feet.
        frequency: stride frequency, Hz; None if the contacts are not periodic.
    """

    name: Name
    duty_factor: float
    frequency: float | None


@dataclass(frozen=True)
class Pattern:
    """The individuals whose gaits have the same name.

    Attributes:
        name: name of the gait.
        count: number of individuals.
        member: number of the individual with the highest score, counted from 1.
        score: highest score.
    """

    name: str
    count: int
    member: int
    score: float


def patterns(gaits: Sequence[RepertoireGait], scores: Floats) -> list[Pattern]:
    """Group gaits by name, highest score first; gaits without a name come last.

    Args:
        gaits: gaits of individuals.
        scores: scores of the individuals, (individuals,).
    """
    found: dict[str, list[int]] = {}
    for index, gait in enumerate(gaits):
        found.setdefault(gait.name.name, []).append(index)
    best = {name: max(indices, key=lambda index: scores[index]) for name, indices in found.items()}
    named = [
        Pattern(name, len(found[name]), index + 1, float(scores[index]))
        for name, index in best.items()
    ]
    return sorted(named, key=lambda one: (one.name == NONE, -one.score))


def gaits_of(
    experiment: Experiment, genomes: Genomes, workers: int | None = None
) -> Iterator[list[RepertoireGait]]:
    """Yield the gaits of genomes in order, in groups.

    The names are the same as those of `analyse_individual`, which would take many minutes for
    15,625 spiders. This function is faster: it takes the positions of the feet along the body from
    the skeletons of a few individuals.

    Args:
        experiment: experiment with the body.
        genomes: genomes, (individuals, genes).
        workers: number of workers; None for a number that suits the body.
    """
    if not len(genomes):
        return
    places, names = _feet(experiment, genomes)
    work = partial(_name_gaits, places=places, names=names)
    with Evaluator(experiment, workers) as evaluator:
        step = 2 * evaluator.workers * _CHUNK
        for start in range(0, len(genomes), step):
            part = genomes[start : start + step]
            chunks = np.split(part, range(_CHUNK, len(part), _CHUNK))
            yield from evaluator.map(work, chunks)


def _feet(experiment: Experiment, genomes: Genomes) -> tuple[Floats, tuple[str, ...]]:
    """Return the mean positions of the feet in the body's frame, (feet, 3) m, and their names."""
    samples = genomes[np.unique(np.linspace(0, len(genomes) - 1, _SAMPLES).astype(int))]
    motion = move_genomes(experiment, samples)
    entry, organism = experiment.entries["organism"], experiment.organism
    channel = organism.channels.get("stance")
    with plugin_errors(entry, "drawing an individual"):
        skeletons = [organism.skeleton(motion, index) for index in range(len(samples))]
    first = skeletons[0]
    if channel is None or channel.axes != ("frames", "feet") or first.contacts is None:
        raise GaitsimError(
            f"gaits of the body {entry.name!r} cannot be named, because it has no feet or no "
            "channel 'stance' of foot contacts",
            allowed="a body with feet, and a channel 'stance' with the axes (frames, feet)",
        )
    places = [relative_feet(skeleton).mean(axis=0) for skeleton in skeletons]
    count = first.contacts.shape[1]
    names = first.contact_names or tuple(f"foot {number + 1}" for number in range(count))
    return np.median(places, axis=0), names


def _name_gaits(
    experiment: Experiment, genomes: Genomes, places: Floats, names: tuple[str, ...]
) -> list[RepertoireGait]:
    motion = move_genomes(experiment, genomes)
    with plugin_errors(experiment.entries["organism"], "computing the channel 'stance'"):
        stance = np.asarray(motion["stance"]).astype(bool)
    order = body_order(places[None])
    ordered = tuple(names[index] for index in order)
    lasted = _lasted(experiment, motion)
    known = commands_frequency(experiment.organism)
    with plugin_errors(experiment.entries["organism"], "computing the stride frequency"):
        frequency = motion[STRIDE_FREQUENCY] if known else np.zeros(len(stance))
    frames = np.full(len(stance), stance.shape[1])
    if lasted is not None:
        frames = np.array([frames_in(one, motion.frame_rate) for one in lasted])
    found: dict[int, RepertoireGait] = {}
    for upright in np.unique(frames).tolist():  # few of an archive's gaits fall
        same = np.flatnonzero(frames == upright)
        stepped = feet_of_each(
            stance[same, :upright][..., order],
            ordered,
            motion.frame_rate,
            experiment.organism.dynamic,
            np.asarray(frequency, np.float64)[same],
        )
        for index, (feet, stride) in zip(same.tolist(), stepped, strict=True):
            if index in motion.failures:
                failed = Name(NONE, "the motion failed")
                found[index] = RepertoireGait(failed, float("nan"), None)
                continue
            phases = consistency = np.full(len(feet), np.nan)
            if stride is not None:
                phases, consistency = phases_of(feet, stride)
            still = False
            if not any(foot.steps for foot in feet):  # rare, so a skeleton's cost is acceptable
                with plugin_errors(experiment.entries["organism"], "drawing an individual"):
                    skeleton = experiment.organism.skeleton(motion, index)
                still = stands(skeleton, slice(upright))
            name, _ = name_of(feet, stride, phases, consistency, places[None, order], still)
            duty = float(np.mean([foot.duty_factor for foot in feet]))
            found[index] = RepertoireGait(name, duty, None if stride is None else stride.frequency)
    return [found[index] for index in range(len(stance))]


def _lasted(experiment: Experiment, motion: Motion) -> Floats | None:
    """Return the time before a fall, (population,) s; None for a body that cannot fall."""
    with plugin_errors(experiment.entries["organism"], "measuring a population"):
        found = experiment.organism.measures(motion).get("lasted")
        if found is None or found.unit != "s":
            return None
        return np.asarray(found.values, np.float64)
