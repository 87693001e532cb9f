"""Results of a gait in unseen worlds, as tables and sentences for a terminal."""

import math
from collections.abc import Iterator

from gaitsim.evaluation.worlds import describe
from gaitsim.gait.sensitivity import Effect
from gaitsim.gait.unseen import SCORE, UnseenResults
from gaitsim.render.terminal.explanation import Passage, format_or_dash
from gaitsim.render.terminal.text import number


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
    notes = [f"{format_falls(found).capitalize()}.{nominal}"]
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
    condition = spaced(found.effects[0].condition) if found.effects else ""
    worst = f"; most sensitive to {condition}" if condition else ""
    worlds = f"{len(found.worlds):,} unseen world{'s' * (len(found.worlds) != 1)}"
    return (
        f"In {worlds}: median {format_or_dash(found.median, 2)}{unit}, worst tenth "
        f"{format_or_dash(found.worst_tenth, 2)}{unit}, {format_falls(found)}{worst}"
    )


def format_strongest(found: UnseenResults) -> str:
    """Return the most harmful condition and range, such as 'friction below 0.6', or a dash."""
    if not found.effects:
        return "–"
    return f"{found.effects[0].condition} {format_range(found.effects[0], found)}"


def format_falls(found: UnseenResults) -> str:
    """Return the number of worlds in which the body falls, such as '3 falls'."""
    return {0: "no falls", 1: "1 fall"}.get(found.falls, f"{found.falls:,} falls")


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


def spaced(condition: str) -> str:
    """Return the name of a condition with spaces, such as 'side slope'."""
    return condition.replace("_", " ")


def format_percent(share: float) -> str:
    """Format a share in per cent, or as a dash if it is not finite."""
    return f"{number(100 * share, 0)} %" if math.isfinite(share) else "–"


def format_spans(found: UnseenResults) -> Iterator[str]:
    """Yield the range of each condition, such as 'slope −3 to 3°'."""
    for name, (low, high) in found.ranges.items():
        yield f"{name} {_short(low)} to {format_quantity(high, found.units[name])}"


def _short(value: float) -> str:
    return f"{value:z.3g}".replace("-", "−")
