"""Explanations of a score, a gait and results in unseen worlds, for a terminal."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, MissingFunctionError
from gaitsim.evaluation.worlds import describe
from gaitsim.gait import GaitAnalysis, compare_bodies
from gaitsim.gait.changed import QuantityPair, engine_of
from gaitsim.gait.report import quantities
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import summarise, term_changes, terms_over_time
from gaitsim.gait.sensitivity import Effect
from gaitsim.gait.worlds import (
    HORN_ERROR,
    SCORE,
    CheckResults,
    FeedbackResults,
    UnseenResults,
)
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import number

TIMES = 4  # columns in the table of terms over time
DIGITS = {"Froude number": 4, "unsupported": 1, "joint travel": 1}  # decimals; 3 by default
_SCORE_TOLERANCE = 1e-9  # relative tolerance between the recorded and the replayed score


@dataclass(frozen=True)
class Passage:
    """A part of an explanation: a table with text above and below it.

    Attributes:
        title: heading; '' for none.
        failure: reason why the motion fails; '' if it succeeds.
        warning: warning about the values in the table; '' for none.
        columns: headings of the columns; () for no table.
        rows: cells of the table, row by row.
        numbers: headings of the columns that hold numbers.
        notes: sentences below the table.
    """

    title: str = ""
    failure: str = ""
    warning: str = ""
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    numbers: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def explanation(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> Iterator[Passage]:
    """Yield the terms of the score over time and by generation, and a summary."""
    try:
        yield _terms_over_time(individual)
    except MissingFunctionError as error:  # the recorded terms are known without the fitness
        title = f"Score analysis: {number(individual.score, 4)}"
        yield Passage(title, warning=f"Terms over time are not available: {error.what}")
    if individual.best_of:
        yield _terms_over_generations(individual, history)
    sentences = summarise(
        individual.scored_terms, history, individual.best_of, individual.experiment.fitness.unit
    )
    if sentences:
        yield Passage(notes=tuple(f"• {sentence.replace(' -', ' −')}" for sentence in sentences))


def travel_and_stability(gait: GaitAnalysis) -> Passage:
    """Return the travel, slip and stability of a gait."""
    rows = tuple(
        (name, format_or_dash(value, DIGITS.get(name, 3)), unit, meaning)
        for name, (value, unit, meaning) in quantities(gait).items()
    )
    notes = tuple(f"Not available: {missing}." for missing in gait.missing)
    columns = ("measure", "value", "", "meaning")
    title = f"Means over {gait.trials} trials" if gait.trials > 1 else ""
    return Passage(title, columns=columns, rows=rows, numbers=("value",), notes=notes)


def compare_with_twin(individual: Individual, twin: Individual) -> Passage:
    """Compare a gait on the kinematic body with the same gait on the body's physical twin."""
    title = f"The same joint angles in rigid-body physics, {twin.experiment.name}"
    return _compare(individual, twin, title, ("kinematic", "physics"))


def compare_engines(individual: Individual, other: Individual) -> Passage:
    """Compare a gait in its own physics engine with the same gait in a different engine."""
    names = engine_of(individual), engine_of(other)
    return _compare(individual, other, f"The same gait in the engine {names[1]}", names)


def _compare(
    individual: Individual, other: Individual, title: str, columns: tuple[str, str]
) -> Passage:
    failure, found = other.replayed_failure, compare_bodies(individual, other)
    rows = tuple(
        (one.name, _format(one, one.own), _format(one, one.other), one.unit) for one in found
    )
    notes = tuple(
        f"The forward distance is {100 * one.other / one.own:.0f} % "
        "of the distance in the first column."
        for one in found
        if one.name == "forward" and one.own > 0
    )
    return Passage(
        title,
        failure and f"The simulation fails: {failure}",
        columns=("measure", *columns, ""),
        rows=rows,
        numbers=columns,
        notes=notes,
    )


def _format(one: QuantityPair, value: float) -> str:
    return format_or_dash(value, DIGITS.get(one.name, 3))


def format_or_dash(value: float | None, digits: int) -> str:
    """Return a number as text, or a dash if it is missing or not finite."""
    return "–" if value is None or not math.isfinite(value) else number(value, digits)


def _terms_over_time(individual: Individual) -> Passage:
    title = f"Score analysis: {number(individual.replayed_score, 4)}"
    failure = individual.replayed_failure
    if failure:
        failure = f"The motion fails: {failure}"
    recorded, warning = individual.score, ""
    if individual.worlds:
        title += " in its own world"
        warning = f"The run recorded {number(recorded, 4)}{individual.over_worlds}."
    elif abs(individual.replayed_score - recorded) > _SCORE_TOLERANCE * max(1.0, abs(recorded)):
        warning = (
            f"The run recorded {number(recorded, 4)}: the body or the fitness has changed since."
        )
    try:
        found = terms_over_time(individual)
    except GaitsimError as error:
        warning = f"{warning}\nTerms over time are not available: {error.what}".strip()
        terms = tuple((name, number(value)) for name, value in individual.replayed_terms.items())
        return Passage(title, failure, warning, ("term", "value"), terms, ("value",))
    chosen = np.unique(np.linspace(0, len(found.seconds) - 1, TIMES + 1).astype(int)[1:])
    heads = tuple(f"{found.seconds[index]:.1f} s" for index in chosen)
    rows = tuple((name, *map(number, values[chosen])) for name, values in found.terms.items())
    notes = () if found.timed else ("The fitness reads no channel over time, so the terms are for "
                                    "the whole motion.",)  # fmt: skip
    return Passage(
        title, failure, warning, ("term, if the motion ended at", *heads), rows, heads, notes
    )


def _terms_over_generations(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> Passage:
    first, found = term_changes(history, individual.generation)
    last = individual.generation
    heads = (f"best of {first}", f"best of {last}", f"mean of {first}", f"mean of {last}")
    rows = tuple(
        (one.name, *map(number, (one.first, one.last, one.mean_first, one.mean_last)))
        for one in found
    )
    return Passage(columns=("term, generation", *heads), rows=rows, numbers=heads)


def check_results(found: CheckResults) -> Passage:
    """Return what a gait keeps in each world that its body names, and whether it holds."""
    measure = f"{found.measure} {found.unit}".rstrip()
    rows = tuple(
        (
            describe(world),
            format_or_dash(one.result, 3),
            format_percent(found.kept_in(at)),
            one.failure or "falls" * one.fell or "strays" * one.strays,
        )
        for at, (world, one) in enumerate(zip(found.worlds, found.outcomes, strict=True))
    )
    summary = found.summary
    depends = tuple(f"The gait depends on the {one}." for one in found.depends_on)
    return Passage(
        "Checks",
        warning="" if found.holds else summary,
        columns=("world", measure, "kept", ""),
        rows=rows,
        numbers=(measure, "kept"),
        notes=(summary,) if found.holds else depends,
    )


def feedback_results(found: FeedbackResults) -> Passage:
    """Return how straight a gait walks with inexact servo horns, with and without reflexes."""
    both = {"with reflexes": found.feeling, "without": found.blind}
    columns = ("RMS yaw", "kept", "without errors", "falls")
    rows = tuple(
        (
            name,
            f"{number(math.degrees(one.yaw), 1)}°",
            format_percent(one.kept(one.mean)),
            f"{number(one.nominal.result, 2)} {one.unit}".rstrip(),
            f"{one.falls} of {len(one.worlds)}",
        )
        for name, one in both.items()
    )
    return Passage(
        f"Servo horns {HORN_ERROR:g}° off, {len(found.blind.worlds)} draws",
        columns=("", *columns),
        rows=rows,
        numbers=columns,
        notes=(f"Reflexes: {', '.join(found.reflexes)}.",),
    )


def perturbation_results(found: Robustness) -> Passage:
    """Return the score of a gait under each perturbation, and whether it collapses."""
    numbers = ("score", "falls by")
    rows = tuple(
        (one.name, number(one.score), f"{100 * one.fall:.0f} %", one.sign)
        for one in found.perturbations
    )
    about = (
        f"A fall of 100 % is {number(found.worth)}: the absolute value of the score, or its gain "
        "since the first generation if that is larger. Random perturbations are means of ten draws."
    )
    return Passage(
        "Robustness to perturbations",
        columns=("perturbation", *numbers, "") if rows else (),
        rows=rows,
        numbers=numbers,
        notes=(*([about] if rows else []), *(f"Not available: {one}." for one in found.missing)),
    )


def world_results(found: UnseenResults) -> Iterator[Passage]:
    """Yield the distribution of the results across worlds, and the conditions that reduce them."""
    shares = {"best": 1.0, "upper quartile": 0.75, "median": 0.5, "lower quartile": 0.25}
    results = {
        "nominal world": found.nominal.result,
        **{name: found.quantile(share) for name, share in shares.items()},
        "worst tenth, mean": found.worst_tenth,
        "worst": found.quantile(0.0),
    }
    measure = f"{found.measure} {found.unit}".rstrip()
    kept = ("of nominal",) if found.nominal.result > 0 else ()
    rows = tuple(
        (name, format_or_dash(value, 3), *(format_percent(found.kept(value)) for _ in kept))
        for name, value in results.items()
    )
    nominal = " It falls in the nominal world, too." if found.nominal.fell else ""
    moves = found.measure == SCORE or max(found.quantile(1.0), found.nominal.result) > 0
    nowhere = "" if moves else "It does not move forward in any world."
    notes = [f"{found.falls_in_words.capitalize()}.{nominal}"]
    if found.failures:
        notes.append(f"A motion fails: {found.failures[0]}")
    notes.append(f"Worlds: seed {found.seed}; {', '.join(format_spans(found))}.")
    notes.append(f"Worst world: {describe(found.worst)}.")
    yield Passage(
        f"In {len(found.worlds):,} unseen world{'s' * (len(found.worlds) != 1)}",
        warning=nowhere,
        columns=("", measure, *kept),
        rows=rows,
        numbers=(measure, *kept),
        notes=tuple(notes),
    )
    yield _harmful_conditions(found)


def _harmful_conditions(found: UnseenResults) -> Passage:
    if not found.effects:
        return Passage(notes=("No condition has an effect beyond chance.",))
    loss = f"loss {found.unit}".rstrip()
    rows = tuple(
        (
            one.condition,
            format_range(one, found),
            number(one.loss, 3),
            f"{int(found.fell[inside].sum())} of {int(inside.sum())}",
            f"{100 * one.share:.0f} %",
        )
        for one in found.effects
        for inside in [one.within(found.conditions[one.condition])]
    )
    numbers = (loss, "falls in range", "variance explained")
    return Passage(
        "Sensitive to",
        columns=("condition", "worst range", *numbers),
        rows=rows,
        numbers=numbers,
        notes=("No other condition has an effect beyond chance.",),
    )


def summary_line(found: UnseenResults) -> str:
    """Return a summary on one line, such as 'In 100 unseen worlds: median 1.92 m, …'."""
    unit = f" {found.unit}".rstrip()
    condition = found.effects[0].condition.replace("_", " ") if found.effects else ""
    worst = f"; most sensitive to {condition}" if condition else ""
    worlds = f"{len(found.worlds):,} unseen world{'s' * (len(found.worlds) != 1)}"
    return (
        f"In {worlds}: median {format_or_dash(found.median, 2)}{unit}, worst tenth "
        f"{format_or_dash(found.worst_tenth, 2)}{unit}, {found.falls_in_words}{worst}"
    )


def format_range(effect: Effect, found: UnseenResults) -> str:
    """Return the harmful range of a condition, such as 'below −1° or above 1°'."""
    least, most = found.ranges[effect.condition]
    unit = found.units[effect.condition]
    words = []
    for low, high in effect.hurting:
        if low <= least:
            words.append(f"below {format_quantity(high, unit)}")
        elif high >= most:
            words.append(f"above {format_quantity(low, unit)}")
        else:
            words.append(f"{_short(low)} to {format_quantity(high, unit)}")
    return " or ".join(words)


def format_quantity(value: float, unit: str) -> str:
    """Return a value of a condition with its unit, such as '0.05 s' or '3°'."""
    return f"{_short(value)}{unit if unit == '°' else f' {unit}'.rstrip()}"


def format_percent(share: float) -> str:
    """Format a share in per cent, or as a dash if it is not finite."""
    return f"{number(100 * share, 0)} %" if math.isfinite(share) else "–"


def format_spans(found: UnseenResults) -> Iterator[str]:
    """Yield the range of each condition, such as 'slope −3 to 3°'."""
    for name, (low, high) in found.ranges.items():
        yield f"{name} {_short(low)} to {format_quantity(high, found.units[name])}"


def _short(value: float) -> str:
    return f"{value:z.3g}".replace("-", "−")
