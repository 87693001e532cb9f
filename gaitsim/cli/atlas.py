"""`gaitsim atlas`."""

import math
from typing import Annotated

import typer

from gaitsim.actions.action import parse_pairs
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
from gaitsim.console.printing import status
from gaitsim.errors import GaitsimError
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
        created = RunSnapshot(create_run(loaded, out, start))
        evolve_run(created, place, workers=workers, json=json)


def parse_axes(text: str | None) -> dict[str, tuple[float, float] | None] | None:
    """Return the ends of each axis of `--axes NAME=LOW:HIGH,…`; None for a name without ends."""
    if text is None:
        return None
    allowed = "NAME=LOW:HIGH,… with LOW below HIGH, such as forward=0:2"
    found: dict[str, tuple[float, float] | None] = {}
    for name, ends in parse_pairs(text, "--axes", allowed).items():
        try:
            low, high = (float(end) for end in ends.split(":")) if ends else (0.0, 1.0)
            if not -math.inf < low < high < math.inf:
                raise ValueError
        except ValueError:
            raise GaitsimError(
                f"invalid range for the axis {name!r}: {ends!r}", where="--axes", allowed=allowed
            ) from None
        found[name] = (low, high) if ends else None
    return found


def parse_cells(text: str | None) -> int | tuple[int, ...] | None:
    """Return the number of cells of `--cells 5000`, or the counts per axis of `--cells 40x30`."""
    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"invalid number of cells: {text!r}",
            where="--cells",
            allowed="a number of Voronoi cells, such as 5000, or one count per axis of a grid, "
            "such as 40x30",
        )
    return int(text) if len(parts) == 1 else tuple(map(int, parts))
