"""Print the breakdown of a score and its robustness."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.cli.console import output, print_table
from gaitsim.errors import GaitsimError
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import summarise, term_changes, terms_over_time
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import number

TIMES = 4  # columns of the terms over time
_MOVED = 1e-9  # relative tolerance between the recorded and the replayed score


def print_score_breakdown(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> None:
    """Print the terms of the score over time and over the generations, and a summary."""
    console = output()
    console.print(f"\nWhy it scored {number(individual.replayed_score, 4)}", style="bold")
    recorded = individual.score
    if individual.replayed_failure:
        console.print(Text(f"The motion fails: {individual.replayed_failure}", style="red"))
    if abs(individual.replayed_score - recorded) > _MOVED * max(1.0, abs(recorded)):
        warning = (
            f"The run recorded {number(recorded, 4)}: the body or the fitness has changed since."
        )
        console.print(warning, style="yellow")
    try:
        over_time = terms_over_time(individual)
    except GaitsimError as error:
        console.print(f"Terms over time are not available: {error.what}", style="yellow")
        terms = individual.replayed_terms.items()
        rows = [[name, number(value)] for name, value in terms]
        print_table(["term", "value"], rows, numbers=["value"])
    else:
        chosen = np.unique(np.linspace(0, len(over_time.seconds) - 1, TIMES + 1).astype(int)[1:])
        heads = [f"{over_time.seconds[index]:.1f} s" for index in chosen]
        rows = [[name, *map(number, values[chosen])] for name, values in over_time.terms.items()]
        print_table(["term, had it ended at", *heads], rows, numbers=heads)
        if not over_time.timed:
            console.print("The fitness reads nothing over time: terms are of the whole motion.")
    if individual.generation:
        first, found = term_changes(history, individual.generation)
        heads = [f"best of {first}", f"of {individual.generation}", f"mean of {first}", "mean then"]
        rows = [
            [one.name, *map(number, (one.first, one.last, one.mean_first, one.mean_last))]
            for one in found
        ]
        console.print()
        print_table(["term, generation", *heads], rows, numbers=heads)
    words = summarise(individual.replayed_terms, history, individual.generation or None)
    if words:
        console.print()
    for sentence in words:
        console.print(f"• {sentence.replace(' -', ' −')}")


def print_robustness(found: Robustness) -> None:
    """Print the score under each perturbation, and whether it collapses."""
    console = output()
    console.print("\nRobustness to perturbations", style="bold")
    if found.perturbations:
        rows = [
            (p.name, number(p.score), f"{100 * p.fall:.0f} %", Text(p.sign, style="red"))
            for p in found.perturbations
        ]
        numbers = "score", "falls by"
        print_table(["the same, but", *numbers, ""], rows, numbers)
        console.print(
            f"Shares of {number(found.worth)}, what the score is worth; draws by chance are "
            "means of ten."
        )
    for missing in found.missing:
        console.print(f"Not available: {missing}.", style="yellow")
