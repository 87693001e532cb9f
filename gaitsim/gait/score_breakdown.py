"""The breakdown of a score: its terms over time, over the generations, and in words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Channel, Motion
from gaitsim.evaluation.scoring import evaluate_motion
from gaitsim.gait.feet import Floats
from gaitsim.individual import Individual
from gaitsim.storage.files.history import COLUMNS, MEAN

PARTS = 10  # number of parts of the motion; the terms are evaluated at the end of each
DOMINANT = 0.6  # share of the sum of absolute terms from which a term dominates
NEGLIGIBLE = 0.01  # share of the sum, or of the range of the best score, that is negligible
CANCELLED = 0.5  # share of the gains from which losses cancel them
RELEVANT = 0.05  # share of all changes below which a change is omitted


@dataclass(frozen=True, eq=False)
class TermsOverTime:
    """The terms of a score over time.

    Attributes:
        seconds: times, (times,) s.
        terms: values of each term if the motion had ended at these times, by name, (times,).
        timed: whether the fitness reads any channel over time; if not, the terms are constant.
    """

    seconds: Floats
    terms: Mapping[str, Floats]
    timed: bool


def terms_over_time(individual: Individual) -> TermsOverTime:
    """Evaluate the first tenth of the motion, the first two tenths, and so on.

    A fitness returns only totals, but a motion can be cut. The score of a part is the score that
    the individual would have if its motion ended there. It is not cumulative: a term that is a
    mean over time, such as drift, can fall as well as rise.
    """
    experiment, motion = individual.experiment, individual.motion
    frames = len(individual.skeleton.segments)
    ends = np.unique(np.linspace(0, frames, PARTS + 1)[1:].round().astype(int))
    ends = ends[ends >= min(2, frames)]
    channels = {name: experiment.organism.channels[name] for name in experiment.fitness.needs}
    parts = [cut_motion(motion, channels, end) for end in ends.tolist()]
    rows = [evaluate_motion(experiment, part, part.population).terms_of(0) for part in parts]
    return TermsOverTime(
        (ends - 1) / motion.frame_rate,
        {name: np.array([row[name] for row in rows]) for name in individual.replayed_terms},
        any(channel.over_time for channel in channels.values()),
    )


def cut_motion(motion: Motion, channels: Mapping[str, Channel], frames: int) -> Motion:
    """Return the given channels of a motion; channels over time are cut to their first frames."""
    return Motion(
        motion.frame_rate,
        {
            name: motion[name][:, :frames] if channel.over_time else motion[name]
            for name, channel in channels.items()
        },
    )


@dataclass(frozen=True)
class TermChange:
    """A term over the generations.

    Attributes:
        name: name of the term.
        first, last: value for the best individual, in the first generation and in the last.
        mean_first, mean_last: mean over the population in these generations.
    """

    name: str
    first: float
    last: float
    mean_first: float
    mean_last: float

    @property
    def gain(self) -> float:
        """The increase from first to last."""
        return self.last - self.first


def term_changes(
    history: Mapping[str, Floats], generation: int
) -> tuple[int, tuple[TermChange, ...]]:
    """Return the changes of the terms from the first generation of a stage to `generation`.

    Returns:
        The number of the first generation of the stage, and the terms in the order of the history.
        Terms of earlier fitness functions are omitted.
    """
    names = [
        name
        for name in history
        if name not in COLUMNS
        and MEAN + name in history
        and np.isfinite(history[name][generation - 1])
    ]
    same = np.isfinite([history[name][:generation] for name in names]).all(axis=0)
    if "stage" in history:
        same &= history["stage"][:generation] == history["stage"][generation - 1]
    first = int(np.flatnonzero(~same)[-1]) + 1 if not same.all() else 0
    return first + 1, tuple(
        TermChange(
            name,
            float(history[name][first]),
            float(history[name][generation - 1]),
            float(history[MEAN + name][first]),
            float(history[MEAN + name][generation - 1]),
        )
        for name in names
    )


def summarise(
    terms: Mapping[str, float],
    history: Mapping[str, Floats],
    generation: int | None,
    unit: str = "",
) -> tuple[str, ...]:
    """Summarise a score in words: terms that dominate, hardly change, or cancel.

    Args:
        terms: terms of the individual's score.
        history: history of the run.
        generation: generation of the individual; None for a gait from a file.
        unit: unit of the score, '' for a pure number.
    """
    total = sum(abs(value) for value in terms.values())
    dominant = _describe_dominant(terms, total)
    if generation is None:
        return (*dominant, *_describe_negligible(terms, total))
    first, found = term_changes(history, generation)
    return (
        *dominant,
        *_describe_changes(first, found),
        *_describe_settled(history, first, found, generation, unit),
    )


def _describe_dominant(terms: Mapping[str, float], total: float) -> tuple[str, ...]:
    if len(terms) == 1 or not total:
        return ()
    return tuple(
        f"{name} dominates: {abs(value) / total:.0%} of all gains and losses"
        for name, value in terms.items()
        if abs(value) >= DOMINANT * total
    )


def _describe_negligible(terms: Mapping[str, float], total: float) -> tuple[str, ...]:
    found = [name for name, value in terms.items() if abs(value) < NEGLIGIBLE * total]
    return (f"negligible: {', '.join(found)}",) if found else ()


def _describe_changes(first: int, found: tuple[TermChange, ...]) -> tuple[str, ...]:
    """Describe the terms that rose, and those that fell."""
    total = sum(abs(change.gain) for change in found)
    rose = sorted(
        (change for change in found if change.gain > RELEVANT * total), key=lambda c: -c.gain
    )
    fell = sorted(
        (change for change in found if change.gain < -RELEVANT * total), key=lambda c: c.gain
    )
    if not rose and not fell:
        return ()
    gain = sum(change.gain for change in found)
    parts = ", ".join(f"{change.name} {change.gain:+z.3f}" for change in (*rose, *fell))
    sentences = [f"since generation {first} the best score changed by {gain:+z.3f}: {parts}"]
    if rose and fell and -sum(c.gain for c in fell) >= CANCELLED * sum(c.gain for c in rose):
        sentences.append(
            f"{_sum_of_names(rose)} and {_sum_of_names(fell)} largely cancel "
            f"({sum(c.gain for c in rose):+.3f} and {sum(c.gain for c in fell):+.3f})"
        )
    return tuple(sentences)


def _describe_settled(
    history: Mapping[str, Floats],
    first: int,
    found: tuple[TermChange, ...],
    generation: int,
    unit: str,
) -> tuple[str, ...]:
    """Describe the terms of the best individual that hardly changed, with bounds of the changes."""
    part = slice(first - 1, generation)
    best = history["best"][part]
    spread = float(np.ptp(best[np.isfinite(best)])) if np.isfinite(best).any() else 0.0
    count = generation - first + 1
    same, settled = [], []
    for change in found:
        values = history[change.name][part]
        away = np.abs(values - change.last) > NEGLIGIBLE * spread
        before = int(np.flatnonzero(away)[-1]) + 1 if away.any() else 0
        # A term that settled in the last half of the search may just have converged.
        if count > 2 and before < count / 2:
            when = f"since generation {first + before}"
            moved = float(np.ptp(values[before:]))
            if moved:
                bound = f"{upper_bound(moved):g} {unit}".rstrip()
                settled.append(f"{change.name} by less than {bound} {when}")
            else:
                same.append(f"{change.name} {when}")
    return (
        *((f"unchanged: {', '.join(same)}",) if same else ()),
        *((f"changed little compared with the score: {', '.join(settled)}",) if settled else ()),
    )


def upper_bound(value: float) -> float:
    """Return the smallest number of two digits that is greater than a positive number."""
    power = math.floor(math.log10(value)) - 1
    digits = math.floor(value / 10.0**power)
    while float(f"{digits}e{power}") <= value:
        digits += 1
    return float(f"{digits}e{power}")


def _sum_of_names(terms: list[TermChange]) -> str:
    return " + ".join(change.name for change in terms)
