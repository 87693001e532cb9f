"""The conformance check: whether plugins keep their contract, and how to fix them.

In a package's own tests:

    from pathlib import Path

    import pytest

    from gaitsim.testing import check_package

    def test_it_conforms():
        for report in check_package(Path(__file__).parents[1]):
            assert report.ok, report

Each plugin is examined in a child process, so that an endless loop, an exit or output does no
harm. `gaitsim plugins check` does the same on the command line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsim.registry import find
from gaitsim.testing.report import Finding, Report
from gaitsim.testing.rules.packages import Chosen, chosen, rivals
from gaitsim.testing.sandbox import SECONDS, watch

__all__ = ["SECONDS", "Finding", "Report", "check", "check_chosen", "check_package"]


def check(
    kind: str, name: str, *, options: Mapping[str, Any] | None = None, seconds: float = SECONDS
) -> Report:
    """Check one installed plugin, or one preset.

    Args:
        kind: 'organism', 'fitness', 'selection', 'crossover', 'mutation' or 'experiments'.
        name: its name.
        options: its options that are not the defaults.
        seconds: the timeout.

    Raises:
        PluginError: there is no such plugin, or two packages claim the name.
    """
    (report,) = watch([find(kind, name)], options, seconds=seconds)
    return report


def check_package(reference: str | Path | None, *, seconds: float = SECONDS) -> list[Report]:
    """Check everything that a package registers.

    Args:
        reference: the name of an installed plugin or package, or the folder of a package that
            need not be installed; None for everything installed.
        seconds: the timeout of each.

    Raises:
        GaitsimError: nothing has that name, or the folder holds no package with plugins.
    """
    with chosen(reference) as found:
        return list(check_chosen(found, seconds=seconds))


def check_chosen(found: Chosen, *, seconds: float = SECONDS) -> Iterator[Report]:
    """Check one after the other; yield each report as soon as it is ready."""
    for report in watch(found.entries, seconds=seconds, path=found.path):
        rival = rivals(report.entry)
        yield replace(report, findings=(rival, *report.findings)) if rival else report
