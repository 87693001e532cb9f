"""`gaitsim experiments show`."""

import io

from gaitsim.cli.console import echo
from gaitsim.cli.options import ExperimentName
from gaitsim.cli.streams import results
from gaitsim.experiment import load_experiment


def show(
    name: ExperimentName,
) -> None:
    """Print an experiment as TOML, with every option, to edit and run.

    [bold]Example[/bold]

    gaitsim experiments show spider > my-spider.toml

    gaitsim run my-spider.toml
    """
    text = load_experiment(name).to_toml()
    stream = results()
    if isinstance(stream, io.TextIOWrapper) and not stream.isatty():
        # TOML is UTF-8 by definition, whatever the locale.
        stream.reconfigure(encoding="utf-8")
    echo(text, end="")
