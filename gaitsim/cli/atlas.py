"""`gaitsim atlas`."""

from typing import Annotated

import typer

from gaitsim.cli.options import (
    Dask,
    Detach,
    ExperimentName,
    From,
    Generations,
    Json,
    Population,
    RunFolder,
    Seed,
    Set,
    Workers,
)
from gaitsim.cli.parsing import parse_axes, parse_cells
from gaitsim.console.printing import status
from gaitsim.render.terminal.text import visible


def atlas(
    body: ExperimentName,
    axes: Annotated[
        str | None,
        typer.Option(
            metavar="NAME=LOW:HIGH,…",
            help="Measures that distinguish gaits, each with its range; for duty factors (the "
            "share of the time that a foot is on the ground), the range defaults to 0:1. Default: "
            "the axes of the preset, or else the duty factor of each leg.",
        ),
    ] = None,
    cells: Annotated[
        str | None,
        typer.Option(
            metavar="N|NxN…",
            help="Number of Voronoi cells, such as 5000, or of cells along each axis of a grid, "
            "such as 40x30. Each cell keeps its best gait.",
        ),
    ] = None,
    generations: Generations = None,
    population: Population = None,
    seed: Seed = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    from_: From = None,
    out: RunFolder = None,
    detach: Detach = False,
    json: Json = False,
) -> None:
    """Evolve an atlas of a body's gaits: the best gait for each way of using the legs.

    An atlas is a run of the search map-elites. The command evolves the preset NAME-atlas if it
    exists, and otherwise the given experiment with map-elites as its search.

    [bold]Examples[/bold]

    gaitsim atlas spider

    gaitsim atlas my_robot.urdf --cells 5000

    gaitsim atlas hexapod --axes 'duty factor,yaw=-90:90' --cells 30x30
    """
    from gaitsim.cli.evolving import (
        chosen_place,
        command_line_options,
        evolve_run,
        starting_individual,
    )
    from gaitsim.experiment import load_atlas
    from gaitsim.runs.creation import create_run
    from gaitsim.runs.snapshot import RunSnapshot

    given = command_line_options(generations, population, seed, set_)
    ends, count = parse_axes(axes), parse_cells(cells)
    with status(f"Reading {visible(body)} …"):
        loaded = load_atlas(body, axes=ends, cells=count, set=given)
    start = starting_individual(loaded, from_)
    with chosen_place(dask, workers, detach=detach) as place:
        evolve_run(RunSnapshot(create_run(loaded, out, start)), place, workers=workers, json=json)
