"""`gaitsim experiments list` and `gaitsim experiments show`."""

import io

from gaitsim.actions.action import EXPERIMENT, Action, argument
from gaitsim.console.printing import echo, notice, print_table
from gaitsim.console.streams import results
from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.registry.loading import describe_preset


class ListExperiments(Action):
    """List the presets of all installed packages."""

    def do(self) -> None:
        """Print the list."""
        rows = [
            (name, describe_preset(name), " and ".join(claim.package for claim in claims))
            for name, claims in entries(EXPERIMENTS).items()
        ]
        print_table(["name", "description", "package"], rows)


class ShowExperiment(Action):
    """Print an experiment as TOML with all its options, to edit and run.

    [bold]Example[/bold]

    gaitsim experiments show spider > my-spider.toml

    gaitsim run my-spider.toml
    """

    name: str = argument(EXPERIMENT, "NAME|FILE", completion="preset_names")

    def do(self) -> None:
        """Print the experiment."""
        from gaitsim.experiment import load_experiment

        experiment = load_experiment(self.name)
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
