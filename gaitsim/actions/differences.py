"""`gaitsim differences`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.actions.action import JSON, Action, argument
from gaitsim.choices import Axis, Quantity, Theme
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names

if TYPE_CHECKING:
    from gaitsim.storage.compare_runs import ComparedRun

ROWS = 14  # lines of the curves in the terminal
WIDEST = 100  # columns of the curves, at most


class Differences(Action):
    """Compare runs: their curves, results and differing options.

    A single run of each experiment proves little; 'gaitsim compare' repeats experiments.

    [bold]Examples[/bold]

    gaitsim differences spider spider-2

    gaitsim differences spider spider-2 --by evaluations --plot curves.pdf
    """

    title: ClassVar[str] = "Run differences"

    runs: Names = argument(
        "names of runs in runs/, or their folders",
        "RUN",
        allowed="names separated by spaces",
        shown=True,
    )
    quantity: Quantity = option("best", "quantity to show over the generations")
    by: Axis | None = option(
        None,
        "horizontal axis",
        unset="'generation', or 'evaluations' if the population sizes differ",
    )
    plot: Path | None = option(
        None, "plot the curves to a PNG, SVG or PDF file", placeholder="FILE", written=True
    )
    theme: Theme = option("light", "colour theme of the plot")
    json_lines: bool = JSON

    def do(self) -> None:
        """Print and plot the comparison."""
        from gaitsim.console.printing import echo, notice, print_json
        from gaitsim.render.plots.overlay import plot_overlay
        from gaitsim.render.plots.style import THEMES, check_target
        from gaitsim.storage.compare_runs import (
            RunsReader,
            differing_options,
            fair_axis,
            least_evaluations,
            warning,
        )
        from gaitsim.storage.files.folder import find_run

        if self.plot is not None:
            check_target(self.plot)
        compared_runs = RunsReader([find_run(run) for run in self.runs]).read()
        for one in compared_runs:
            if one.problem is not None:
                raise one.problem
        if problem := warning(compared_runs):
            notice(f"Warning: {problem}")
        by = self.by or fair_axis(compared_runs)
        if self.plot is not None:
            plot_overlay(compared_runs, self.quantity, by, self.plot, THEMES[self.theme])
        if self.json_lines:
            within = least_evaluations(compared_runs)
            print_json(
                {
                    "runs": [
                        {**one.to_dict(), "score_within": one.best_within(within)}
                        for one in compared_runs
                    ],
                    "within": within,
                    "warning": warning(compared_runs) or None,
                    "options": {
                        row.key: list(row.values) for row in differing_options(compared_runs)
                    },
                    "plot": None if self.plot is None else str(self.plot),
                }
            )
            return
        _show(compared_runs, self.quantity, by)
        if self.plot is not None:
            echo(f"\n{self.plot}")


def _show(runs: Sequence[ComparedRun], quantity: str, by: str) -> None:
    from rich.text import Text

    from gaitsim.console.characters import LINES, lines
    from gaitsim.console.printing import output, print_table
    from gaitsim.render.series import run_curves
    from gaitsim.render.terminal.curves import plot, sample
    from gaitsim.render.terminal.text import visible
    from gaitsim.storage.compare_runs import comparison_table, quantity_label

    console = output()
    drawn = [one for one in runs if one.history]
    heads: list[Text] = []
    for one in runs:
        head = Text()
        if one in drawn:
            at = drawn.index(one)
            head.append(f"{sample(at)} ", LINES[at % len(LINES)])
        heads.append(head.append(visible(one.label)))
    marks = [mark for one in drawn for mark in one.stage_marks(by)]
    if drawn:
        console.print(f"{quantity_label(quantity)} by {by}", style="bold")
        colours = [LINES[at % len(LINES)] for at in range(len(drawn))]
        styles = ["", "bright_black", "", *reversed(colours)]
        series = run_curves(runs, quantity, by)
        picture = plot(series, min(console.width, WIDEST), ROWS, by, marks, whole=True)
        for line in lines(*picture, styles):
            console.print(line, end="\n", no_wrap=True, crop=False)
        console.print()
    rows = comparison_table(runs)
    print_table(
        ["", *heads],
        ([row.key, *row.values] for row in rows),
    )
