"""Print the breakdown of a score and its robustness."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.cli.console import number, output, table
from gaitsim.errors import GaitsimError
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import summarise, term_changes, terms_over_time
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import visible

TIMES = 4  # columns of the terms over time
_MOVED = 1e-9  # relative tolerance between the recorded and the replayed score


def print_score_breakdown(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> None:
    """Print the terms of the score over time and over the generations, and a summary."""
    console = output()
    console.print(f"\nWhy it scored {number(individual.replayed_score, 4)}", style="bold")
    _warn_if_moved(individual)
    note = ""
    try:
        over_time = terms_over_time(individual)
    except GaitsimError as error:
        console.print(
            Text(f"Terms over time are not available: {visible(error.what)}", style="yellow")
        )
        made = table("term", "value", numbers=("value",))
        for name, value in individual.replayed_terms.items():
            made.add_row(visible(name), number(value))
    else:
        chosen = np.unique(np.linspace(0, len(over_time.seconds) - 1, TIMES + 1).astype(int)[1:])
        heads = [f"{over_time.seconds[index]:.1f} s" for index in chosen]
        made = table("term, had it ended at", *heads, numbers=tuple(heads))
        for name, values in over_time.terms.items():
            made.add_row(visible(name), *(number(values[index]) for index in chosen))
        if not over_time.timed:
            note = "The fitness reads nothing over time: terms are of the whole motion."
    console.print(made, markup=False)
    if note:
        console.print(note)
    if individual.generation:
        first, found = term_changes(history, individual.generation)
        heads = [f"best of {first}", f"of {individual.generation}", f"mean of {first}", "mean then"]
        made = table("term, generation", *heads, numbers=tuple(heads))
        for change in found:
            row = (change.first, change.last, change.mean_first, change.mean_last)
            made.add_row(visible(change.name), *map(number, row))
        console.print()
        console.print(made, markup=False)
    words = summarise(individual.replayed_terms, history, individual.generation or None)
    if words:
        console.print()
    for sentence in words:
        console.print(f"• {visible(sentence).replace(' -', ' −')}", markup=False)


def _warn_if_moved(individual: Individual) -> None:
    recorded = individual.score
    if abs(individual.replayed_score - recorded) <= _MOVED * max(1.0, abs(recorded)):
        return
    output().print(
        Text(
            f"The run recorded {number(recorded, 4)}: the body or the fitness has changed since.",
            style="yellow",
        )
    )


def print_robustness(found: Robustness) -> None:
    """Print the score under each perturbation, and whether it collapses."""
    console = output()
    console.print("\nRobustness to perturbations", style="bold")
    if found.perturbations:
        made = table("the same, but", "score", "falls by", "", numbers=("score", "falls by"))
        for perturbation in found.perturbations:
            made.add_row(
                visible(perturbation.name),
                number(perturbation.score),
                f"{100 * perturbation.fall:.0f} %",
                Text(perturbation.sign, style="red"),
            )
        console.print(made, markup=False)
        console.print(
            f"Shares of {number(found.worth)}, what the score is worth; draws by chance are "
            "means of ten."
        )
    for missing in found.missing:
        console.print(Text(f"Not available: {visible(missing)}.", style="yellow"))
