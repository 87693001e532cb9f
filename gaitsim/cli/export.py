"""`gaitsim export`."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class Format(StrEnum):
    """The formats of a gait file."""

    mat = "mat"
    csv = "csv"
    npz = "npz"


def export(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    format: Annotated[
        Format | None,
        typer.Option(help="MATLAB/Octave, CSV or NumPy. Default: as --out ends, or mat."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File to write. Default: in the run's exports folder.")
    ] = None,
    generation: Annotated[
        int | None, typer.Option(min=1, help="The best of this generation. Default: of all.")
    ] = None,
) -> None:
    """Write the champion's joint angles to a file: radians, a row a frame.

    [bold]Examples[/bold]

    gaitsim export spider --format mat

    gaitsim export spider --out gait.csv
    """
    from gaitsim.export.gait import gait_of, write_gait
    from gaitsim.runs.folder import find_run
    from gaitsim.runs.reader import Run

    opened = Run(find_run(run))
    gait = gait_of(opened, generation)
    chosen = format or Format.__members__.get(out.suffix[1:].lower() if out else "", Format.mat)
    path = out or opened.exports() / f"gait-generation-{gait.generation}.{chosen}"
    write_gait(gait, path, chosen.value)
    frames, joints = gait.angles.shape
    print(f"{path}: {frames} frames × {joints} joints at {gait.frame_rate:g} Hz, radians")
