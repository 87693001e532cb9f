"""The `gaitsim` command and its subcommands."""

from typing import Annotated

import typer

from gaitsim.cli import (
    analyse,
    compare,
    differences,
    experiments,
    export,
    fork,
    imitate,
    play,
    plot,
    plugins,
    resume,
    run,
    runs,
    serve,
    show,
    study,
    tui,
    verify,
    video,
)
from gaitsim.cli.help import Command, Group

app = typer.Typer(
    name="gaitsim",
    cls=Group,
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


for command in (
    run.run,
    resume.resume,
    fork.fork,
    runs.runs,
    show.show,
    export.export,
    plot.plot,
    video.video,
    play.play,
    analyse.analyse,
    imitate.imitate,
    study.study,
    compare.compare,
    differences.differences,
    verify.verify,
    tui.tui,
    serve.serve,
):
    app.command(cls=Command)(command)
app.add_typer(experiments.app)
app.add_typer(plugins.app)
