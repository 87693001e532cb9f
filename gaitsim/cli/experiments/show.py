"""`gaitsim experiments show`."""

import io

from gaitsim.cli.options import ExperimentName
from gaitsim.console.printing import echo, notice
from gaitsim.console.streams import results


def show(
    name: ExperimentName,
) -> None:
    """Print an experiment as TOML with all its options, to edit and run.

    [bold]Example[/bold]

    gaitsim experiments show spider > my-spider.toml

    gaitsim run my-spider.toml
    """
    from gaitsim.experiment import load_experiment

    experiment = load_experiment(name)
    stream = results()
    on_screen = stream.isatty()
    text = experiment.to_toml(brief=on_screen)
    if on_screen and text != experiment.to_toml():
        notice(
            "Long texts are shortened on the screen. For the full texts: "
            "gaitsim experiments show … > FILE"
        )
    if isinstance(stream, io.TextIOWrapper) and not stream.isatty():
        # TOML is UTF-8 by definition, whatever the locale.
        stream.reconfigure(encoding="utf-8")
    echo(text, end="")
