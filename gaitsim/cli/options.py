"""Arguments and options shared by several commands."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli import completion

RunName = Annotated[
    str,
    typer.Argument(
        metavar="RUN",
        help="Name of a run in runs/, or its folder.",
        autocompletion=completion.run_names,
    ),
]
RunOrCode = Annotated[
    str,
    typer.Argument(
        metavar="RUN|CODE",
        help="Name of a run in runs/, or its folder; or a challenge code (from 'gaitsim share'), a "
        "file that contains a code, or '-' to read a code from standard input.",
        autocompletion=completion.run_names,
    ),
]
WorldSeed = Annotated[
    int | None,
    typer.Option(help="Seed for drawing the worlds of --worlds. Default: 0.", show_default=False),
]
ExperimentName = Annotated[
    str,
    typer.Argument(
        help="Name of a preset, or path of a TOML file or a robot file such as URDF.",
        metavar="NAME|FILE",
        autocompletion=completion.preset_names,
    ),
]
Generations = Annotated[int | None, typer.Option(help="Number of generations.")]
Population = Annotated[int | None, typer.Option(help="Number of individuals per generation.")]
Seed = Annotated[int | None, typer.Option(help="Seed of all random numbers.")]
From = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="FILE|RUN[@N|#N]|CODE",
        help="Start from a given individual: the first population consists of it and "
        "variations of it. Give a champion file, a run (its champion), RUN@N (the best "
        "individual of generation N), RUN#N (member N of its front or archive) or a "
        "challenge code.",
        autocompletion=completion.run_names,
    ),
]
RunFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="FOLDER",
        help="Folder of the run. Default: a folder in runs/ named after the experiment.",
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Set an option of the experiment, such as mutation.rate=0.1; may be repeated.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        min=1,
        max=1024,
        help="Maximum number of parallel workers; fewer or none are used if that is faster. "
        "Does not affect the result.",
    ),
]
Dask = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|local",
        help="Use a Dask cluster: the address of its scheduler, such as tcp://host:8786, or "
        "'local' to start a cluster on this machine with the number of workers given by "
        "--workers. Does not affect the result.",
    ),
]
Detach = Annotated[
    bool,
    typer.Option(
        "--detach",
        help="Evolve in the background, until the run is finished or 'gaitsim stop' stops it.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object per line, for scripts.")]
