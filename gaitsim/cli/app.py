"""The `gaitsim` command and its subcommands."""

from collections.abc import Mapping
from typing import Annotated, ClassVar

import typer

from gaitsim.cli.help import LazyGroup


class _Commands(LazyGroup):
    package = "gaitsim.cli"
    lines: ClassVar[Mapping[str, str]] = {
        "run": "Evolve a gait and keep the run on disk.",
        "resume": (
            "Go on with a run, exactly as if it had never stopped; or train it on under other "
            "options."
        ),
        "fork": "Copy a run, to let the copy go its own way under other options.",
        "runs": "List the runs in a folder, oldest first; or delete runs.",
        "show": (
            "Show a run in full: what it is made of, how far it is, its stages, and its champion."
        ),
        "export": (
            "Write the champion's joint angles to a file: radians, a row a frame; or for servos."
        ),
        "plot": "Plot a run, or how its champion moves, at the width of a journal's column.",
        "video": "Make a video of the champion as it moves: MP4 or GIF.",
        "play": "Play a champion in the terminal, until Ctrl-C.",
        "analyse": "Say which gait emerged, and why it scored.",
        "imitate": "Train a network that imitates the champion, and let it walk on its own.",
        "study": (
            "Sweep options over all cores; results in one table, with surfaces and a summary."
        ),
        "compare": "Compare experiments over repeats, with statistics that a reviewer accepts.",
        "differences": (
            "Show runs over each other: their curves, what became of them, which options differ."
        ),
        "verify": (
            "Make generations of a run again, and see that they are the same to the last bit."
        ),
        "tui": "Open the terminal UI: runs, new ones, live, replayed, compared.",
        "serve": "Open the terminal UI in a browser, on this machine alone unless told otherwise.",
        "experiments": "List and show presets.",
        "plugins": "Installed bodies and operators, and new ones.",
    }


app = typer.Typer(
    name="gaitsim",
    cls=_Commands,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Begin with: gaitsim run spider",
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"gaitsim {version('gaitsim')}")
        raise typer.Exit


@app.callback()
def gaitsim(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Evolve gaits in your terminal."""
