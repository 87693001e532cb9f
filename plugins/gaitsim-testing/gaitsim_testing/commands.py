"""`gaitsim plugins check`."""

import sys
from typing import TYPE_CHECKING

from pydantic import ConfigDict
from rich.text import Text

from gaitsim.plugin import option
from gaitsim.plugin.commands import Action, argument, output

if TYPE_CHECKING:
    from gaitsim_testing.checking import Checked

BROKEN = 1  # exit code


class CheckPlugins(Action):
    """Check whether plugins fulfil the contract of their kind, and report what to fix.

    The exit code is 1 if a plugin has errors.

    [bold]Examples[/bold]

    gaitsim plugins check

    gaitsim plugins check spider-walk

    gaitsim plugins new hopper

    gaitsim plugins check ./hopper --strict
    """

    model_config = ConfigDict(allow_inf_nan=True)  # the check itself explains its time limits

    reference: str | None = argument(
        "a plugin, a package, or the folder of a package, installed or not",
        "NAME|FOLDER",
        None,
        unset="all installed plugins",
        completion="plugin_names",
    )
    seconds: float = option(120.0, "time limit for each check of a plugin", placeholder="SECONDS")
    strict: bool = option(False, "exit with code 1 even if the check finds no errors, only advice")

    def do(self) -> None:
        """Check the plugins, and print what each check found."""
        from gaitsim.plugin.commands import Progress, interruptible
        from gaitsim_testing.checking import check_plugins
        from gaitsim_testing.packages import select_plugins

        good = True
        with (
            interruptible(),
            select_plugins(self.reference) as found,
            Progress("checking", "plugins", len(found.entries)) as progress,
        ):
            for checked in check_plugins(found, seconds=self.seconds):
                _print_findings(checked)
                good &= not (checked.broken or (self.strict and checked.advice))
                progress.advance()
        if not good:
            sys.exit(BROKEN)


def _print_findings(checked: "Checked") -> None:
    console = output()
    head = Text("✗ " if checked.broken else "✓ ", "red" if checked.broken else "green")
    head.append(f"{checked.entry.kind} {checked.entry.name}", "bold")
    head.append(f"  {checked.entry.source}")
    if rate := checked.rate:
        head.append(f"  {f'{rate:,.0f}' if rate >= 10 else f'{rate:.2g}'} individuals/s")
    console.print(head)
    for level, style, texts in (
        ("error", "red", checked.broken),
        ("advice", "yellow", checked.advice),
    ):
        for text in texts:
            first, *rest = text.split("\n")
            console.print(f"  {level}: {first}", style=style)
            for line in rest:
                console.print(f"  {line}")
