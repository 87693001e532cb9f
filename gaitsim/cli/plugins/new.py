"""`gaitsim plugins new`."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.console.printing import output
from gaitsim.scaffold import PREFIX, new_package


def new(
    name: Annotated[
        str,
        typer.Argument(metavar="NAME", help="Name of the plugin, such as 'hopper'."),
    ],
    kind: Annotated[
        str,
        typer.Option(
            metavar="KIND",
            help="Kind of plugin: organism, fitness, search, selection, crossover, mutation, "
            "plot or exporter.",
        ),
    ] = "organism",
) -> None:
    """Create a ready-to-run package for a new plugin in the folder NAME.

    [bold]Examples[/bold]

    gaitsim plugins new hopper

    gaitsim plugins new sprint --kind fitness

    gaitsim plugins new my-board --kind exporter
    """
    folder = new_package(name, kind, Path())
    plugin = name.removeprefix(PREFIX)
    source = folder / "src" / f"gaitsim_{plugin.replace('-', '_')}" / "__init__.py"
    console = output()
    console.print(f"{folder}: created a package for the {kind} {plugin!r}")
    console.print("\nNext:")
    trial = {
        "organism": f"gaitsim run {plugin}",
        "plot": f"gaitsim plot spider --kind {plugin}",
        "exporter": f"gaitsim export spider --format {plugin}",
    }.get(kind, f"gaitsim run spider --set {kind}.plugin={plugin}")
    for command, what in (
        (f"gaitsim plugins check ./{shlex.quote(str(folder))}", "check its contract"),
        (
            f"pip install -e ./{shlex.quote(str(folder))}",
            "install it; later edits need no reinstallation",
        ),
        (trial, f"try it; its code is in {source}"),
    ):
        console.print(f"  {command}  # {what}")
