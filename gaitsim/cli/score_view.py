"""Print the breakdown of a score and its robustness."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.console.printing import output, print_table
from gaitsim.gait.robustness import Robustness
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import Passage, explanation
from gaitsim.render.terminal.text import number


def print_score_breakdown(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> None:
    """Print the terms of the score over time and over generations, and a summary."""
    for section in explanation(individual, history):
        output().print()
        print_section(section)


def print_section(section: Passage) -> None:
    """Print a section: its title and warnings, its table, and its notes."""
    console = output()
    if section.title:
        console.print(section.title, style="bold")
    if section.failure:
        console.print(Text(section.failure, style="red"))
    if section.warning:
        console.print(Text(section.warning, style="yellow"))
    if section.columns:
        print_table(section.columns, section.rows, section.numbers)
    for note in section.notes:
        console.print(note)


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
        print_table(["perturbation", *numbers, ""], rows, numbers)
        console.print(
            f"A fall of 100 % is {number(found.worth)}: the absolute value of the score, or its "
            "gain since the first generation if that is larger. Random perturbations are means of "
            "ten draws."
        )
    for missing in found.missing:
        console.print(f"Not available: {missing}.", style="yellow")
