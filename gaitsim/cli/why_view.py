"""How it is shown in a terminal why a gait scored, and how robust that is."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.cli.console import number, output, table
from gaitsim.errors import GaitsimError
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import changes, course, in_words
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import visible

TIMES = 4  # columns of the terms over time
_MOVED = 1e-9  # of a score: what a run recorded and what is played now may differ by


def print_why(individual: Individual, history: Mapping[str, NDArray[np.float64]]) -> None:
    """The terms of the score over time and over the generations, and in words."""
    console = output()
    console.print(f"\nWhy it scored {number(individual.replayed_score, 4)}", style="bold")
    _warn_if_moved(individual)
    over_time = course(individual)
    if isinstance(over_time, GaitsimError):
        console.print(
            Text(f"Terms over time are not to be had: {visible(over_time.what)}", style="yellow")
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
    console.print(made, markup=False)
    if not isinstance(over_time, GaitsimError) and over_time.unmoved:
        console.print("The fitness reads nothing over time: terms are of the whole motion.")
    if individual.generation:
        first, found = changes(history, individual.generation)
        heads = [f"best of {first}", f"of {individual.generation}", f"mean of {first}", "mean then"]
        made = table("term, generation", *heads, numbers=tuple(heads))
        for change in found:
            row = (change.first, change.last, change.mean_first, change.mean_last)
            made.add_row(visible(change.name), *map(number, row))
        console.print()
        console.print(made, markup=False)
    words = in_words(individual.replayed_terms, history, individual.generation or None)
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
    """The score under each perturbation, and whether it collapses."""
    console = output()
    console.print("\nHow it bears perturbation", style="bold")
    if found.trials:
        made = table("the same, but", "score", "falls by", "", numbers=("score", "falls by"))
        for trial in found.trials:
            made.add_row(
                visible(trial.name),
                number(trial.score),
                f"{100 * trial.fall:.0f} %",
                Text(trial.sign, style="red"),
            )
        console.print(made, markup=False)
        console.print(
            f"Shares of {number(found.worth)}, what the score is worth; draws by chance are "
            "means of ten."
        )
    for missing in found.missing:
        console.print(Text(f"Not to be had: {visible(missing)}.", style="yellow"))
