"""The `gaitsim` command and its subcommands."""

from typing import Annotated

import typer

from gaitsim.cli.help import group

app = group(
    {
        "run": "Evolve a gait, and save the run in a folder.",
        "resume": "Continue a run exactly as if it had never stopped, optionally with changed "
        "options.",
        "attach": "Watch a run that is evolving in the background or in another program.",
        "stop": "Stop background runs after their current generation, and save them.",
        "fork": "Copy a run, for example to continue the copy with changed options.",
        "runs": "List the runs in a folder, oldest first; find, watch, tag or delete some of them.",
        "show": "Show a run in full: its plugins, progress, stages and champion.",
        "members": "List the members of a run's front or archive.",
        "note": "Show or write the note of a run.",
        "tag": "Show, add or remove tags of a run.",
        "rename": "Rename a run.",
        "trash": "List and restore deleted runs, and delete them permanently.",
        "export": "Export the champion: its joint angles, a file for a robot, or the body in "
        "motion.",
        "plot": "Plot a run, or the motion of its champion, at the width of a journal column.",
        "video": "Make a video of the champion: MP4 or GIF.",
        "play": "Play a champion in the terminal until Ctrl-C.",
        "analyse": "Report which gait evolved and how its score is made up.",
        "steer": "Steer a body with the keyboard: drive a robot in physics, or fly a fly.",
        "differences": "Compare runs: their curves, results and differing options.",
        "share": "Print the champion as a challenge code, which others can verify.",
        "verify": "Repeat a run, study, adaptation or challenge code, and compare every bit.",
        "tui": "Open the terminal UI: list, start, watch, replay and compare runs.",
        "experiments": "List and show presets: the experiments that packages provide.",
        "plugins": "List, show and check plugins, and create new ones.",
    },
    {
        "run": "evolve:EvolveRun",
        "resume": "evolve:Resume",
        "attach": "background:Attach",
        "stop": "background:Stop",
        "fork": "runs:Fork",
        "runs": "run_list:ListRuns",
        "show": "runs:ShowRun",
        "members": "members:ListMembers",
        "note": "runs:EditNote",
        "tag": "runs:EditTags",
        "rename": "runs:Rename",
        "trash": (
            {
                "list": "List the deleted runs of a folder, latest first.",
                "restore": "Restore a deleted run from the trash; the latest, if several have the "
                "name.",
                "empty": "Delete the runs in the trash permanently.",
            },
            {
                "list": "trash:ListTrash",
                "restore": "trash:RestoreRun",
                "empty": "trash:EmptyTrash",
            },
        ),
        "export": "export:Export",
        "plot": "plot:MakePlot",
        "video": "video:MakeVideo",
        "play": "play:Play",
        "analyse": "analyse:Analyse",
        "steer": "gaitsim.cli.steer:Steer",
        "differences": "differences:Differences",
        "share": "share:Share",
        "verify": "verify:VerifyResults",
        "tui": "gaitsim.cli.tui:tui",
        "experiments": (
            {
                "list": "List the presets of all installed packages.",
                "show": "Print an experiment as TOML with all its options, to edit and run.",
            },
            {"list": "experiments:ListExperiments", "show": "experiments:ShowExperiment"},
        ),
        "plugins": (
            {
                "list": "List all plugins by kind, with their packages, without importing them.",
                "show": "Show a plugin's options and, for a body, its channels and conditions.",
                "new": "Create a ready-to-run package for a new plugin in the folder NAME.",
            },
            {
                "list": "plugins:ListPlugins",
                "show": "plugins:ShowPlugin",
                "new": "plugins:NewPlugin",
            },
        ),
    },
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
