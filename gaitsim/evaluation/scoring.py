"""One chunk of a population: moved, judged, and held to the contract."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Motion
from gaitsim.errors import PluginError
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_errors

Scores = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The scores of a population.

    Attributes:
        scores: (population,) float64, more is better; −inf where a term is not finite.
        terms: what the scores are the sums of, by name, each (population,) float64.
        reasons: why a score is −inf, by the individual's index.
    """

    scores: Scores
    terms: dict[str, Scores]
    reasons: dict[int, str]


def evaluate(experiment: Experiment, genomes: Genomes) -> Evaluation:
    """Move and score genomes, (population, genes), which stay as they are.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract; names its package.
    """
    # The body gets its own copy: what it changes in it reaches neither the search nor the
    # checkpoint. And a writable one: compiled code is compiled once more for arrays that are not.
    lent = genomes.copy()
    with plugin_errors(experiment.entries["organism"], "moving a population"):
        motion: object = experiment.organism.move(lent)
    if not np.array_equal(lent, genomes):
        raise broken(experiment, "organism", "changes the genomes that it is given")
    evaluation = evaluate_motion(experiment, motion, len(genomes))
    # A channel may be a view of them.
    if not np.array_equal(lent, genomes):
        raise broken(experiment, "fitness", "changes the motion that it is given")
    return evaluation


def evaluate_motion(experiment: Experiment, motion: object, population: int) -> Evaluation:
    """Score what a body gave as the motion of a population.

    Raises:
        PluginError: the body or the fitness fails or breaks its contract; names its package.
    """
    moved = hold_motion(experiment, motion)
    _hold_channels(experiment, moved, population)
    with plugin_errors(experiment.entries["fitness"], "evaluating a population"):
        given = experiment.fitness.terms(moved)
    if not isinstance(given, dict) or not given:
        raise broken(
            experiment, "fitness", f"returned {given!r:.80} from terms()", "a dict with terms"
        )
    terms = {
        (name := _name(experiment, told)): _term(experiment, name, term, population)
        for told, term in given.items()
    }
    scores = np.zeros(population)
    with np.errstate(over="ignore", invalid="ignore"):
        for term in terms.values():  # in the fitness's own order, so that the last bit is too
            scores += term
    reasons = _failures(experiment, moved)
    scores[list(reasons)] = -np.inf
    for index in np.flatnonzero(~np.isfinite(scores)).tolist():
        if index in reasons:
            continue
        wrong = [f"{name} is {t[index]}" for name, t in terms.items() if not np.isfinite(t[index])]
        reasons[index] = ", ".join(wrong) or "the sum of the terms is too large"
        scores[index] = -np.inf
    return Evaluation(scores, terms, reasons)


def _failures(experiment: Experiment, motion: Motion) -> dict[int, str]:
    """Why individuals broke down, by index, as the body says."""
    for index, reason in motion.failures.items():
        if not (isinstance(index, int) and 0 <= index < motion.population and str(reason)):
            raise broken(
                experiment,
                "organism",
                f"says of the individual {index!r:.80} that it failed: {reason!r:.80}",
                f"an int from 0 to {motion.population - 1}, and a text",
            )
    # Half a character, as names of files may hold, cannot be written.
    return {
        index: str(motion.failures[index]).encode(errors="backslashreplace").decode()
        for index in sorted(motion.failures)
    }


def hold_motion(experiment: Experiment, motion: object) -> Motion:
    """What a body gave as a motion, if it is one.

    Raises:
        PluginError: it is not; names the body's package.
    """
    if not isinstance(motion, Motion):
        raise broken(experiment, "organism", f"moved to a {type(motion).__name__}", "a Motion")
    return motion


def _hold_channels(experiment: Experiment, motion: Motion, population: int) -> None:
    """See that the channels that the fitness reads are there, worked out by the body."""
    for name in experiment.fitness.needs:
        with plugin_errors(experiment.entries["organism"], f"working out the channel {name!r}"):
            shape = np.shape(motion[name])
        if shape[:1] != (population,):
            raise broken(
                experiment,
                "organism",
                f"gave the channel {name!r} the shape {shape}",
                f"(population, …) with a population of {population}",
            )


def _name(experiment: Experiment, name: object) -> str:
    """The name of a term as exactly a text: files take no others, such as those of a StrEnum."""
    if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
        raise broken(
            experiment, "fitness", f"names a term {name!r:.80}", "a printable text, 200 characters"
        )
    return str.__str__(name)


def _term(experiment: Experiment, name: str, term: object, population: int) -> Scores:
    try:
        # A copy: a fitness may return one array again and again.
        values = np.array(term)
        if values.dtype.kind not in "fiub":
            raise TypeError
        values = values.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise broken(
            experiment, "fitness", f"gave {term!r:.80} for the term {name!r}", "real numbers"
        ) from None
    if values.shape != (population,):
        raise broken(
            experiment,
            "fitness",
            f"gave the term {name!r} the shape {values.shape}",
            f"(population,) = ({population},)",
        )
    return values


def broken(experiment: Experiment, kind: str, what: str, allowed: str = "") -> PluginError:
    """The error of a plugin that breaks its contract; names its package."""
    entry = experiment.entries[kind]
    return PluginError(
        f"{entry} {what}",
        where=entry.target,
        allowed=allowed,
        remedy=f"update {entry.package}, or report it to its author",
    )


def hold_terms(experiment: Experiment, before: Evaluation, after: Evaluation) -> None:
    """Hold a fitness to terms of the same names, in the same order, for every motion.

    Raises:
        PluginError: the names differ.
    """
    if list(before.terms) != list(after.terms):
        raise broken(
            experiment,
            "fitness",
            f"gave the terms {', '.join(after.terms)} after {', '.join(before.terms)}",
            "the same names in the same order for every motion",
        )


def joined(experiment: Experiment, parts: Sequence[Evaluation]) -> Evaluation:
    """The evaluation of a population from those of its chunks, in order.

    Raises:
        PluginError: the chunks have different terms.
    """
    if len(parts) == 1:
        return parts[0]
    reasons: dict[int, str] = {}
    start = 0
    for part in parts:
        hold_terms(experiment, parts[0], part)
        reasons.update({start + index: reason for index, reason in part.reasons.items()})
        start += len(part.scores)
    return Evaluation(
        np.concatenate([part.scores for part in parts]),
        {name: np.concatenate([part.terms[name] for part in parts]) for name in parts[0].terms},
        reasons,
    )
