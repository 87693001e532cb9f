"""Arguments and options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli import completion

RunName = Annotated[
    str,
    typer.Argument(
        help="Name of a run under runs/, or its folder.", autocompletion=completion.run_names
    ),
]
RunOrCode = Annotated[
    str,
    typer.Argument(
        metavar="RUN|CODE",
        help="Name of a run under runs/, or its folder; or a challenge code, a file that holds "
        "one, or '-' for standard input.",
        autocompletion=completion.run_names,
    ),
]
BestOf = Annotated[
    int | None, typer.Option(min=1, help="The best of this generation. Default: of all.")
]
MemberOf = Annotated[
    str | None,
    typer.Option(
        "--member",
        metavar="N|NAME=VALUE,…",
        help="This member of the front or archive, which 'gaitsim members' lists; or the best one "
        "near these values, as 'duty factor L2=0'.",
    ),
]
Damage = Annotated[
    list[str] | None,
    typer.Option(
        "--damage",
        metavar="TEXT",
        help="Damage to the body, such as 'L2 lost' or 'R1 femur stuck 20'; may be repeated.",
    ),
]
World = Annotated[
    list[str] | None,
    typer.Option(
        "--world",
        metavar="TEXT",
        help="A condition of the world that the body is in, such as 'friction 0.4'; may be "
        "repeated. 'gaitsim plugins show BODY' lists them.",
    ),
]
Engine = Annotated[
    str | None,
    typer.Option(
        help="Physics engine of a robot, such as bullet; with --physics, of the twin.",
    ),
]
Worlds = Annotated[
    int | None,
    typer.Option(
        "--worlds",
        metavar="N",
        help="Judge it in so many worlds that it has not seen, such as 100: how far, falls, and "
        "which condition hurts most.",
    ),
]
WorldSeed = Annotated[
    int | None, typer.Option(help="Seed of the unseen worlds. Default: 0.", show_default=False)
]
ExperimentName = Annotated[
    str,
    typer.Argument(
        help="A preset's name, or the path of a TOML file, or of a robot's file, such as URDF.",
        metavar="NAME|FILE",
        autocompletion=completion.preset_names,
    ),
]
Generations = Annotated[int | None, typer.Option(help="How many generations.")]
Population = Annotated[int | None, typer.Option(help="Individuals a generation.")]
Seed = Annotated[int | None, typer.Option(help="Seed of all randomness.")]
From = Annotated[
    str | None,
    typer.Option(
        "--from",
        metavar="FILE|RUN[@N]|CODE",
        help="Start from an individual: a champion's file, a run's champion, the best of a "
        "run's generation N, or that of a challenge code. The others are its mutations.",
        autocompletion=completion.run_names,
    ),
]
RunFolder = Annotated[Path | None, typer.Option(help="Folder of the run. Default: runs/<name>.")]
ExportFile = Annotated[
    Path | None, typer.Option(help="File to write. Default: in the run's exports folder.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change any option; may be repeated."),
]
Workers = Annotated[
    int | None,
    typer.Option(
        min=1,
        max=1024,
        help="How many work at a time, where that is faster. Does not change the result.",
    ),
]
Dask = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|local",
        help="Share the work over a Dask cluster: its scheduler's address, such as "
        "tcp://host:8786, or 'local' for --workers of its own. Does not change the result.",
    ),
]
Detach = Annotated[
    bool,
    typer.Option("--detach", help="In the background: until it is finished, or 'gaitsim stop'."),
]
Json = Annotated[bool, typer.Option("--json", help="One JSON object a line, for programs.")]
