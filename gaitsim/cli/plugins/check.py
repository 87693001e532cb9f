"""`gaitsim plugins check`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from gaitsim.cli.completion import plugin_names
from gaitsim.cli.options import Json
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import output, print_json
from gaitsim.console.progress_bar import Progress

if TYPE_CHECKING:
    from gaitsim.testing import Report


BROKEN = 1  # exit code if a plugin has errors


def check(
    reference: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME|FOLDER",
            autocompletion=plugin_names,
            help="A plugin, a package, or the folder of a package, installed or not. "
            "Default: all installed plugins.",
            show_default=False,
        ),
    ] = None,
    seconds: Annotated[
        float, typer.Option(metavar="SECONDS", help="Time limit for each plugin.")
    ] = 120.0,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict", help="Exit with code 1 even if the check finds no errors, only advice."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Check whether plugins fulfil the contract of their kind, and report what to fix.

    The exit code is 1 if a plugin has errors.

    [bold]Examples[/bold]

    gaitsim plugins check

    gaitsim plugins check spider-walk

    gaitsim plugins new hopper

    gaitsim plugins check ./hopper --strict

    gaitsim plugins check --json > findings.jsonl
    """
    from gaitsim.testing import check_plugins
    from gaitsim.testing.rules.packages import select_plugins

    good = True
    with (
        interruptible(),
        select_plugins(reference) as found,
        Progress("checking", "plugins", len(found.entries)) as progress,
    ):
        for report in check_plugins(found, seconds=seconds):
            if json:
                print_json(report.to_json())
            else:
                _print(report)
            good &= report.ok and not (strict and report.findings)
            progress.advance()
    if not good:
        sys.exit(BROKEN)


def _print(report: Report) -> None:
    console = output()
    head = Text("✓ " if report.ok else "✗ ", "green" if report.ok else "red")
    head.append(f"{report.entry.kind} {report.entry.name}", "bold")
    head.append(f"  {report.entry.source}{_figures(report)}")
    console.print(head)
    for finding in report.findings:
        style = "red" if finding.level == "error" else "yellow"
        first, *rest = str(finding).split("\n")
        console.print(f"  {first}", style=style)
        for line in rest:
            console.print(f"  {line}")


def _figures(report: Report) -> str:
    figures = report.figures
    parts = []
    if "import_seconds" in figures:
        parts.append(f"imported in {figures['import_seconds']:.2f} s")
    if "individuals_per_second" in figures:
        rate = figures["individuals_per_second"]
        parts.append((f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}") + " individuals/s")
    return "  " + ", ".join(parts) if parts else ""
