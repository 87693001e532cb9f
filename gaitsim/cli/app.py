"""The `gaitsim` command and its subcommands."""

from typing import Annotated

import typer

from gaitsim.cli.help import group

app = group(
    "gaitsim.cli",
    {
        "run": "Evolve a gait, and save the run in a folder.",
        "atlas": "Evolve an atlas of a body's gaits: the best gait for each way of using the legs.",
        "resume": "Continue a run exactly as if it had never stopped, optionally with changed "
        "options.",
        "attach": "Watch a run that is evolving in the background or in another program.",
        "stop": "Stop background runs after their current generation, and save them.",
        "fork": "Copy a run, for example to continue the copy with changed options.",
        "runs": "List the runs in a folder, oldest first, or delete some of them.",
        "show": "Show a run in full: its plugins, progress, stages and champion.",
        "members": "List the members of a run's front or archive.",
        "note": "Show or write the note of a run.",
        "rename": "Rename a run.",
        "export": "Export the champion: its joint angles, a file for a robot, or the body in "
        "motion.",
        "plot": "Plot a run, or the motion of its champion, at the width of a journal column.",
        "video": "Make a video of the champion: MP4 or GIF.",
        "play": "Play a champion in the terminal until Ctrl-C.",
        "analyse": "Report which gait evolved and how its score is made up.",
        "steer": "Fly a body with the keyboard: each key puts another trained network in control.",
        "adapt": "Find a gait for a damaged body in a few trials, guided by an atlas.",
        "imitate": "Train a network to imitate the champion or a gait file, and evaluate the "
        "gait that the network generates.",
        "study": "Evolve every combination of chosen options, and write a table and figures.",
        "compare": "Compare experiments statistically, with the same number of evaluations for "
        "each repeat.",
        "differences": "Compare runs: their curves, results and differing options.",
        "share": "Print the champion as a challenge code, which others can verify.",
        "gallery": "Create a website from a folder of runs, with a page for each run that plays "
        "its champion.",
        "verify": "Reproduce generations of a run, or the score of a challenge code, bit for bit.",
        "tui": "Open the terminal UI: list, start, watch, replay and compare runs.",
        "serve": "Open the terminal UI in a browser, by default on this machine only.",
        "experiments": "List and show presets: the experiments that packages provide.",
        "robots": "Check robot files, and list the installed robots and servos.",
        "plugins": "List, show and check plugins, and create new ones.",
    },
    (
        "analyse",
        "compare",
        "differences",
        "export",
        "imitate",
        "play",
        "plot",
        "share",
        "study",
        "video",
    ),
    extensible=True,
    name="gaitsim",
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Start with: gaitsim run spider",
)


def _version(given: bool) -> None:
    if given:
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
