"""The `gaitsim` command and its subcommands."""

from typing import Annotated

import typer

from gaitsim.cli.help import group

app = group(
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
            "List and restore deleted runs, and delete them permanently.",
            {"list": "trash:ListTrash", "restore": "trash:RestoreRun", "empty": "trash:EmptyTrash"},
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
            "List and show presets: the experiments that packages provide.",
            {"list": "experiments:ListExperiments", "show": "experiments:ShowExperiment"},
        ),
        "plugins": (
            "List, show and check plugins, and create new ones.",
            {"list": "plugins:ListPlugins", "show": "plugins:ShowPlugin"},
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
