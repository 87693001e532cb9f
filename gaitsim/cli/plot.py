"""`gaitsim plot`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class Kind(StrEnum):
    """What can be plotted."""

    fitness = "fitness"


def plot(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    kind: Annotated[Kind, typer.Option(help="What to plot.")] = Kind.fitness,
    out: Annotated[
        Path | None,
        typer.Option(help="PNG, SVG or PDF to write. Default: in the run's exports folder."),
    ] = None,
) -> None:
    """Plot a run.

    [bold]Examples[/bold]

    gaitsim plot spider --kind fitness

    gaitsim plot spider --kind fitness --out fitness.pdf
    """
    from gaitsim.export.plots import plot_fitness
    from gaitsim.runs.folder import find_run
    from gaitsim.runs.reader import Run

    opened = Run(find_run(run))
    path = out or opened.exports() / f"{kind}.png"
    plot_fitness(opened, path)
    print(path)
