"""One chunk of a population: moved, judged, and held to the contract."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes
from gaitsim.errors import PluginError
from gaitsim.experiment import Experiment
from gaitsim.registry import containing

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


def judge(experiment: Experiment, genomes: Genomes) -> Evaluation:
    """Move and score genomes, (population, genes).

    Raises:
        PluginError: the body or the fitness fails or breaks its contract; names its package.
    """
    with containing(experiment.entries["organism"], "moving a population"):
        motion = experiment.organism.move(genomes)
    with containing(experiment.entries["fitness"], "judging a population"):
        given = experiment.fitness.terms(motion)
    if not isinstance(given, dict) or not given:
        raise _broken(experiment, f"returned {type(given).__name__} {given!r}", "a filled dict")
    terms = {name: _term(experiment, name, term, len(genomes)) for name, term in given.items()}
    scores = np.zeros(len(genomes))
    for term in terms.values():  # in the fitness's own order, so that the last bit is too
        scores += term
    reasons = {}
    for index in np.flatnonzero(~np.isfinite(scores)).tolist():
        wrong = [f"{name} is {term[index]}" for name, term in terms.items()]
        reasons[index] = ", ".join(w for w in wrong if not w[-1].isdigit()) or "the sum overflows"
        scores[index] = -np.inf
    return Evaluation(scores, terms, reasons)


def _term(experiment: Experiment, name: object, term: object, population: int) -> Scores:
    if not isinstance(name, str):
        raise _broken(experiment, f"named a term {name!r}", "names that are texts")
    try:
        values = np.array(term, dtype=np.float64)
    except (TypeError, ValueError):
        raise _broken(experiment, f"gave {term!r} for the term {name!r}", "numbers") from None
    if values.shape != (population,):
        raise _broken(
            experiment,
            f"gave the term {name!r} the shape {values.shape}",
            f"(population,) = ({population},)",
        )
    return values


def _broken(experiment: Experiment, what: str, allowed: str) -> PluginError:
    entry = experiment.entries["fitness"]
    return PluginError(
        f"{entry} {what} from terms()",
        where=entry.target,
        allowed=allowed,
        remedy=f"update {entry.package}, or report it to its author",
    )


def joined(parts: Sequence[Evaluation]) -> Evaluation:
    """The evaluation of a population from those of its chunks, in order."""
    if len(parts) == 1:
        return parts[0]
    reasons: dict[int, str] = {}
    start = 0
    for part in parts:
        reasons.update({start + index: reason for index, reason in part.reasons.items()})
        start += len(part.scores)
    return Evaluation(
        np.concatenate([part.scores for part in parts]),
        {name: np.concatenate([part.terms[name] for part in parts]) for name in parts[0].terms},
        reasons,
    )
