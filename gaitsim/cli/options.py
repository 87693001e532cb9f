"""Arguments and options that several commands share."""

from typing import Annotated

import typer

RunName = Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")]
BestOf = Annotated[
    int | None, typer.Option(min=1, help="The best of this generation. Default: of all.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change any option; may be repeated."),
]
Workers = Annotated[
    int | None,
    typer.Option(min=1, max=1024, help="How many work at a time. Does not change the result."),
]
Dask = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|local",
        help="Share the work over a Dask cluster: its scheduler's address, such as "
        "tcp://host:8786, or 'local' for --workers of its own. Does not change the result.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="One JSON object a line, for programs.")]
