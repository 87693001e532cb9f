"""`gaitsim differences`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from gaitsim.choices import Axis, Quantity, Theme
from gaitsim.cli.completion import run_names
from gaitsim.cli.options import Json
from gaitsim.console.printing import echo, notice, output, print_json, print_table
from gaitsim.render.terminal.text import visible
from gaitsim.runs.files.folder import find_run

if TYPE_CHECKING:
    from gaitsim.study.compare_runs import ComparedRun


ROWS = 14  # lines of the curves in the terminal
WIDEST = 100  # columns of the curves, at most


def differences(
    runs: Annotated[
        list[str],
        typer.Argument(
            help="Names of runs in runs/, or their folders.",
            metavar="RUN",
            autocompletion=run_names,
        ),
    ],
    quantity: Annotated[
        Quantity, typer.Option(help="Quantity to show over the generations.")
    ] = "best",
    by: Annotated[
        Axis | None,
        typer.Option(
            help="Horizontal axis. Default: 'generation', or 'evaluations' if the "
            "population sizes differ."
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Plot the curves to a PNG, SVG or PDF file.")
    ] = None,
    theme: Annotated[Theme, typer.Option(help="Colour theme of the plot.")] = "light",
    json: Json = False,
) -> None:
    """Compare runs: their curves, results and differing options.

    A single run of each experiment proves little; 'gaitsim compare' repeats experiments.

    [bold]Examples[/bold]

    gaitsim differences spider spider-2

    gaitsim differences spider spider-2 --by evaluations --plot curves.pdf
    """
    from gaitsim.render.plots.overlay import plot_overlay
    from gaitsim.render.plots.style import THEMES, check_target
    from gaitsim.study.compare_runs import (
        RunsReader,
        differing_options,
        fair_axis,
        least_evaluations,
        warning,
    )

    if plot is not None:
        check_target(plot)
    compared_runs = RunsReader([find_run(run) for run in runs]).read()
    for one in compared_runs:
        if one.problem is not None:
            raise one.problem
    if problem := warning(compared_runs):
        notice(f"Warning: {problem}")
    by = by or fair_axis(compared_runs)
    if plot is not None:
        plot_overlay(compared_runs, quantity, by, plot, THEMES[theme])
    if json:
        within = least_evaluations(compared_runs)
        print_json(
            {
                "runs": [
                    {**one.to_dict(), "score_within": one.best_within(within)}
                    for one in compared_runs
                ],
                "within": within,
                "warning": warning(compared_runs) or None,
                "options": {row.key: list(row.values) for row in differing_options(compared_runs)},
                "plot": None if plot is None else str(plot),
            }
        )
        return
    _show(compared_runs, quantity, by)
    if plot is not None:
        echo(f"\n{plot}")


def _show(runs: Sequence[ComparedRun], quantity: str, by: str) -> None:
    from gaitsim.cli.characters import LINES, lines
    from gaitsim.render.terminal.curve_view import CurveView, run_curves
    from gaitsim.render.terminal.curves import plot, sample
    from gaitsim.study.compare_runs import comparison_table, quantity_label

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
        picture = plot(series, min(console.width, WIDEST), ROWS, by, marks, CurveView(whole=True))
        for line in lines(*picture, styles):
            console.print(line, end="\n", no_wrap=True, crop=False)
        console.print()
    rows = comparison_table(runs)
    print_table(
        ["", *heads],
        ([row.key, *row.values] for row in rows),
    )
