"""The `gaitsim` command and its subcommands."""

from typing import Annotated

import typer

from gaitsim.cli.help import group

app = group(
    "gaitsim.cli",
    {
        "run": "Evolve a gait and keep the run on disk.",
        "atlas": "Fill an atlas of the gaits of a body: the best one for each way to use the legs.",
        "resume": "Continue a run exactly as if it had never stopped, or with other options.",
        "attach": "Watch a run that evolves in the background, or in another program.",
        "stop": "Stop runs that evolve in the background, after their current generation, and save "
        "them.",
        "fork": "Copy a run, to continue the copy with other options.",
        "runs": "List the runs in a folder, oldest first; or delete runs.",
        "show": "Show a run in full: its plugins, its progress, its stages and its champion.",
        "members": "List the front or the archive that a search keeps.",
        "note": "Show the note of a run, or write it.",
        "rename": "Rename a run.",
        "export": "Write the champion to a file: its joint angles, also for a robot, or its body "
        "in motion.",
        "plot": "Plot a run, or the motion of its champion, at the width of a journal column.",
        "video": "Make a video of the champion: MP4 or GIF.",
        "play": "Play a champion in the terminal, until Ctrl-C.",
        "analyse": "Report which gait emerged, and why it scored.",
        "steer": "Fly a body yourself: keys choose which trained network is in command.",
        "adapt": "Find a gait for a damaged body in a few trials, by the map of an atlas.",
        "imitate": "Train a network that imitates the champion, and let it walk by itself.",
        "study": "Sweep options over all cores: one table, surfaces and a summary.",
        "compare": "Compare experiments by evaluations over repeats, with statistics.",
        "differences": "Compare runs: their curves, their results, the options that differ.",
        "share": "Print the champion as a challenge code, a text that others can verify.",
        "gallery": "Make a site of a folder of runs: a card for each, and a page that plays its "
        "champion.",
        "verify": "Reproduce generations of a run, or the score of a challenge code, to the bit.",
        "tui": "Open the terminal UI: list, start, watch, replay and compare runs.",
        "serve": "Open the terminal UI in a browser, by default on this machine only.",
        "experiments": "List and show presets.",
        "robots": "Check the files of robots, and list the robots and servos that are installed.",
        "plugins": "List, show and check plugins, and create new ones.",
    },
    name="gaitsim",
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
