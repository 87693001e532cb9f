"""The conformance check, which tests plugins against their contracts and suggests fixes.

To run it in the tests of a package:

    from pathlib import Path

    import pytest

    from gaitsim.testing import check_package

    def test_it_conforms():
        for report in check_package(Path(__file__).parents[1]):
            assert report.ok, report

Each plugin is examined in a child process, so that endless loops, exits and output do no harm.
`gaitsim plugins check` runs the same check from the command line.
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
        kind: 'organism', 'fitness', 'search', 'selection', 'crossover', 'mutation' or
            'experiments'.
        name: name of the plugin or preset.
        options: options that differ from the defaults.
        seconds: timeout.

    Raises:
        PluginError: the plugin does not exist, or several packages register the name.
    """
    (report,) = watch([find(kind, name)], options, seconds=seconds)
    return report


def check_package(reference: str | Path | None, *, seconds: float = SECONDS) -> list[Report]:
    """Check everything that a package registers.

    Args:
        reference: name of an installed plugin or package, or folder of a package, which need not
            be installed; None for everything installed.
        seconds: timeout per plugin.

    Raises:
        GaitsimError: the name is unknown, or the folder has no package with plugins.
    """
    with chosen(reference) as found:
        return list(check_chosen(found, seconds=seconds))


def check_chosen(found: Chosen, *, seconds: float = SECONDS) -> Iterator[Report]:
    """Check plugins one after another; yield each report as soon as it is ready."""
    for report in watch(found.entries, seconds=seconds, path=found.path):
        rival = rivals(report.entry)
        yield replace(report, findings=(rival, *report.findings)) if rival else report
