"""`gaitsim plugins check` and `new`."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ConfigDict
from rich.text import Text

from gaitsim.plugin import OPERATORS, option
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


class NewPlugin(Action):
    """Create a ready-to-run package for a new plugin in the folder NAME.

    [bold]Examples[/bold]

    gaitsim plugins new hopper

    gaitsim plugins new sprint --kind fitness

    gaitsim plugins new my-board --kind exporter
    """

    name: str = argument("name of the plugin, such as 'hopper'", "NAME", completion="")
    kind: str = option(
        "organism",
        "kind of plugin: organism, fitness, search, selection, crossover, mutation, reflex, plot "
        "or exporter",
        placeholder="KIND",
    )

    def do(self) -> None:
        """Write the package, and print what to do with it."""
        from gaitsim_testing.scaffold import PREFIX, new_package

        kind = self.kind
        folder = new_package(self.name, kind, Path())
        plugin = self.name.removeprefix(PREFIX)
        source = folder / "src" / f"gaitsim_{plugin.replace('-', '_')}" / "__init__.py"
        console = output()
        console.print(f"{folder}: created a package for the {kind} {plugin!r}")
        console.print("\nNext:")
        preset = "spider-genetic" if kind in OPERATORS else "spider"
        trial = {
            "organism": f"gaitsim run {plugin}",
            "reflex": f"gaitsim run quadruped --set 'organism.reflexes={{ {plugin} = {{}} }}'",
            "plot": f"gaitsim plot spider --kind {plugin}",
            "exporter": f"gaitsim export spider --format {plugin}",
        }.get(kind, f"gaitsim run {preset} --set {kind}.plugin={plugin}")
        for command, what in (
            (f"gaitsim plugins check ./{shlex.quote(str(folder))}", "check its contract"),
            (
                f"pip install -e ./{shlex.quote(str(folder))}",
                "install it; later edits need no reinstallation",
            ),
            (trial, f"try it; its code is in {source}"),
        ):
            console.print(f"  {command}  # {what}")
