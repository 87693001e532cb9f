"""Evaluate one chunk of a population: move it, score it, and check plugin contracts."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Motion
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.values import values_to_read
from gaitsim.evaluation.worlds import draw_worlds, in_world
from gaitsim.experiment import Experiment
from gaitsim.registry import Entry, contract_error, plugin_errors
from gaitsim.registry.entry_points import SCORE
from gaitsim.repr_mixin import ReprField, ReprMixin

Scores = NDArray[np.float64]
LARGEST_SCORE = 1e100
"""Largest magnitude of a score; an individual beyond it has failed."""


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation(ReprMixin):
    """The scores of a population.

    Attributes:
        scores: score of each individual, (population,) float64, −inf if it failed or the sum of its
            terms is not finite or too large. Higher is better.
        terms: terms of the scores by name, each (population,) float64.
        reasons: reason for each score of −inf, by the index of the individual.
        values: terms and measures that the search reads, by name, each (population,).
    """

    scores: Scores
    terms: dict[str, Scores]
    reasons: dict[int, str]
    values: dict[str, Scores] = field(default_factory=dict)

    def terms_of(self, individual: int) -> dict[str, float]:
        """Return the terms of one individual's score by name."""
        return {name: float(values[individual]) for name, values in self.terms.items()}

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "population": len(self.scores),
            "best": float(self.scores.max(initial=-np.inf)),
            "failed": len(self.reasons) or "",
            "terms": ", ".join(self.terms),
        }


Evaluate = Callable[[Genomes, int], Evaluation]
"""A function that scores genomes, (population, genes), in the worlds of a generation."""


def evaluate(
    experiment: Experiment,
    genomes: Genomes,
    generation: int = 1,
    on_world: Callable[[], object] = lambda: None,
) -> Evaluation:
    """Move and score genomes, (population, genes), in the worlds of the experiment.

    An individual that violates a constraint fails.

    Args:
        experiment: experiment with the body, the fitness and the worlds.
        genomes: genomes, which are not changed.
        generation: number of the generation, counted from 1, in whose worlds they move.
        on_world: called after each world.
    """
    return combine_worlds(experiment, evaluate_worlds(experiment, genomes, generation, on_world))


def evaluate_worlds(
    experiment: Experiment,
    genomes: Genomes,
    generation: int,
    on_world: Callable[[], object] = lambda: None,
    part: slice = slice(None),
) -> Evaluation:
    """Move and score genomes, (population, genes), in a part of the worlds, without constraints.

    Returns:
        The evaluations in these worlds one after the other, joined: (worlds · population,).
    """
    if not experiment.worlds.count:
        evaluation = evaluate_here(experiment, genomes)
        on_world()
        return evaluation
    each = []
    for world in draw_worlds(experiment, generation)[part]:
        each.append(evaluate_here(in_world(experiment, world), genomes))
        on_world()
    return join_evaluations(experiment, each)


def constrain(experiment: Experiment, evaluation: Evaluation) -> Evaluation:
    """Return an evaluation in which individuals fail that violate a constraint."""
    constraints = experiment.constraints
    if not constraints.names:
        return evaluation
    summed = experiment.entries["fitness"].name == SCORE and "score" not in evaluation.terms
    for name in constraints.names if summed else ():
        if name in evaluation.terms:
            raise GaitsimError(
                f"the constrained value {name!r} is added to the score",
                where=str(experiment.entries["organism"]),
                allowed=f"a dict with the value 'score', besides {name!r}",
            )
    violations = constraints.violations(evaluation.values)
    scores, reasons = evaluation.scores.copy(), dict(evaluation.reasons)
    for index, number in np.argwhere(~(violations <= 0)).tolist():
        value = float(evaluation.values[constraints.names[number]][index])
        reasons.setdefault(index, constraints.reason(number, value))
        scores[index] = -np.inf
    return replace(evaluation, scores=scores, reasons=dict(sorted(reasons.items())))


def evaluate_here(experiment: Experiment, genomes: Genomes) -> Evaluation:
    """Move and score genomes in the body's own world, without constraints."""
    # The body gets a copy, so that it cannot change the genomes of the search or the checkpoint.
    # The copy is writable, because Numba would recompile for read-only arrays.
    passed, body = genomes.copy(), experiment.entries["organism"]
    with plugin_errors(body, "moving a population"):
        motion: object = experiment.organism.move(passed)
    if not np.array_equal(passed, genomes):
        raise contract_error(body, "modifies the genomes passed to it")
    evaluation = evaluate_motion(experiment, motion, len(genomes))
    read = values_to_read(
        experiment, check_motion(body, motion), evaluation.scores, evaluation.terms
    )
    # A channel may be a view of the genomes, which the fitness may have changed.
    if not np.array_equal(passed, genomes):
        raise contract_error(experiment.entries["fitness"], "modifies the motion passed to it")
    return replace(evaluation, values=read)


def combine_worlds(experiment: Experiment, evaluation: Evaluation) -> Evaluation:
    """Combine the joined evaluations of a population in all worlds of the experiment, in order.

    Each term and value is the mean over an individual's worst `experiment.worlds.counted` worlds.
    An individual that fails in one world, or violates a constraint, has failed.
    """
    worlds = experiment.worlds.count
    if not worlds:
        return constrain(experiment, evaluation)
    scores = evaluation.scores.reshape(worlds, -1)
    counted = np.argsort(scores, axis=0, kind="stable")[: experiment.worlds.counted]

    def mean(values: Scores) -> Scores:
        # NumPy would sum a single individual's worlds in another order than those of several.
        with np.errstate(over="ignore", invalid="ignore"):
            picked = np.take_along_axis(values.reshape(scores.shape), counted, axis=0)
            return np.asarray(reduce(np.add, picked) / len(picked))

    terms = {name: mean(term) for name, term in evaluation.terms.items()}
    values = {name: mean(value) for name, value in evaluation.values.items()}
    reasons: dict[int, str] = {}
    for place, reason in evaluation.reasons.items():
        world, index = divmod(place, scores.shape[1])
        reasons.setdefault(index, f"{reason}, in world {world + 1} of {worlds}")
    total = _sum_terms(terms, reasons)
    if "score" in values:
        values["score"] = total
    combined = Evaluation(total, terms, dict(sorted(reasons.items())), values)
    return constrain(experiment, combined)


def evaluate_motion(experiment: Experiment, motion: object, population: int) -> Evaluation:
    """Score the object that a body returned as a motion; the evaluation's `values` are empty."""
    body, fitness = experiment.entries["organism"], experiment.entries["fitness"]
    moved = check_motion(body, motion)
    _check_channels(experiment, moved, population)
    moved.declared = experiment.organism.channels
    with plugin_errors(fitness, "evaluating a population"):
        returned = experiment.fitness.terms(moved)
    if not isinstance(returned, dict) or not returned:
        raise contract_error(
            fitness, f"returned {returned!r:.80} from terms()", "a dict with terms"
        )
    terms = {
        (name := _check_term_name(fitness, key)): _check_term(fitness, name, term, population)
        for key, term in returned.items()
    }
    reasons = _failures(body, moved)
    return Evaluation(_sum_terms(terms, reasons), terms, reasons)


def _sum_terms(terms: Mapping[str, Scores], reasons: dict[int, str]) -> Scores:
    """Return the sums of the terms, with −inf for failed individuals; add missing reasons."""
    scores = np.zeros(len(next(iter(terms.values()))))
    with np.errstate(over="ignore", invalid="ignore"):
        for term in terms.values():  # the last bit of a sum depends on this order
            scores += term
    # Larger scores cannot be plotted or averaged: their differences and squares are not finite.
    for index in np.flatnonzero(~(np.abs(scores) <= LARGEST_SCORE)).tolist():
        wrong = [f"{name} is {t[index]}" for name, t in terms.items() if not np.isfinite(t[index])]
        reasons.setdefault(index, ", ".join(wrong) or "the sum of the terms is too large")
    scores[list(reasons)] = -np.inf
    return scores


def _failures(body: Entry, motion: Motion) -> dict[int, str]:
    """Return the failures that the body reports: reasons by index."""
    for index, reason in motion.failures.items():
        if not (isinstance(index, int) and 0 <= index < motion.population and str(reason)):
            raise contract_error(
                body,
                f"reports {reason!r:.80} as the failure of the individual {index!r:.80}",
                f"an int from 0 to {motion.population - 1}, and a string",
            )
    # Lone surrogates, which names of files may contain, cannot be encoded.
    return {
        index: str(motion.failures[index]).encode(errors="backslashreplace").decode()
        for index in sorted(motion.failures)
    }


def move_genomes(experiment: Experiment, genomes: Genomes) -> Motion:
    """Return the motion of genomes, (population, genes), which are not changed, without a score."""
    body = experiment.entries["organism"]
    with plugin_errors(body, "moving a population"):
        motion: object = experiment.organism.move(genomes.copy())
    return check_motion(body, motion)


def check_motion(body: Entry, motion: object) -> Motion:
    """Check that the object returned by a body is a motion, and return it."""
    if not isinstance(motion, Motion):
        raise contract_error(body, f"returned a {type(motion).__name__} as its motion", "a Motion")
    return motion


def _check_channels(experiment: Experiment, motion: Motion, population: int) -> None:
    """Compute the channels that the fitness reads, and check their axes."""
    body, channels = experiment.entries["organism"], experiment.organism.channels
    for name in experiment.fitness.needs:
        with plugin_errors(body, f"computing the channel {name!r}"):
            shape = np.shape(motion[name])
        if shape[:1] != (population,) or not channels[name].fits(shape):
            raise contract_error(
                body,
                f"returned the channel {name!r} with the shape {shape}",
                f"{channels[name].shape}, as declared, with a population of {population}",
            )


def _check_term_name(fitness: Entry, name: object) -> str:
    """Return the name of a term as a plain str, as files do not support subclasses (StrEnum)."""
    if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
        raise contract_error(
            fitness, f"names a term {name!r:.80}", "a printable string of 1 to 200 characters"
        )
    return str.__str__(name)


def _check_term(fitness: Entry, name: str, term: object, population: int) -> Scores:
    try:
        # A copy, because the fitness may reuse the array.
        values = np.array(term)
        if values.dtype.kind not in "fiub":
            raise TypeError
        values = values.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        raise contract_error(
            fitness, f"returned {term!r:.80} for the term {name!r}", "real numbers"
        ) from None
    if values.shape != (population,):
        raise contract_error(
            fitness,
            f"returned the term {name!r} with the shape {values.shape}",
            f"(population,) = ({population},)",
        )
    return values


def check_terms(experiment: Experiment, before: Evaluation, after: Evaluation) -> None:
    """Check that a fitness returns the same terms in the same order for every motion."""
    if list(before.terms) != list(after.terms):
        raise contract_error(
            experiment.entries["fitness"],
            f"returned the terms {', '.join(after.terms)} after {', '.join(before.terms)}",
            "the same names in the same order for every motion",
        )


def join_evaluations(experiment: Experiment, parts: Sequence[Evaluation]) -> Evaluation:
    """Join evaluations one after the other, such as those of consecutive chunks of a population."""
    if len(parts) == 1:
        return parts[0]
    reasons: dict[int, str] = {}
    start = 0
    for part in parts:
        check_terms(experiment, parts[0], part)
        reasons.update({start + index: reason for index, reason in part.reasons.items()})
        start += len(part.scores)
    return Evaluation(
        np.concatenate([part.scores for part in parts]),
        {name: np.concatenate([part.terms[name] for part in parts]) for name in parts[0].terms},
        reasons,
        {name: np.concatenate([part.values[name] for part in parts]) for name in parts[0].values},
    )
