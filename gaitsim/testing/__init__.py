"""The conformance check, which tests plugins against their contracts and suggests fixes.

To run it in the tests of a package:

    from pathlib import Path

    import pytest

    from gaitsim.testing import check_package

    def test_it_conforms():
        for report in check_package(Path(__file__).parents[1]):
            assert report.ok, report

Each plugin is examined in a child process, so that endless loops, exits and output cannot harm the
caller.
`gaitsim plugins check` runs the same check from the command line.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsim.registry import find
from gaitsim.testing.report import Finding, Report
from gaitsim.testing.rules.packages import PluginSelection, check_unique_name, select_plugins
from gaitsim.testing.sandbox import SECONDS, examine_in_processes

__all__ = ["SECONDS", "Finding", "Report", "check", "check_package", "check_plugins"]


def check(
    kind: str, name: str, *, options: Mapping[str, Any] | None = None, seconds: float = SECONDS
) -> Report:
    """Check one installed plugin, or one preset.

    Rules of all kinds: the import finishes in time. Every option has a help text, bounds, and a
    default within them, and is unchanged after it is written to an experiment file and read back.
    Results are bit-identical in a repeated call and in another process. Arguments are not modified,
    nothing is printed, and the global random generator is not used.

    - Body: genomes belong to their space. Channels exist, are declared and finite, and have the
      declared axes. Each individual moves identically alone, in another order, in chunks and, if
      declared, in threads. Skeleton, rig, measures and `play` are valid. A steered body moves
      identically however frames are split into calls, and repeats a drive from its options. A lost
      leg changes neither the genome space nor the shapes of channels. The speed is measured with a
      population of 100, or with three individuals if the body is slow and loops over them.
    - Fitness: terms have the right shape and constant names. Only the channels in `needs` are read.
      Scores of individuals are independent.
    - Search: the names and dtypes of the state are constant. Results are the same after the state
      is stored and loaded. Genomes belong to the space, and their number is right. Equal, huge and
      −∞ scores cause no error. Start points and the optional methods are valid.
    - Selection: indices are valid for random, equal, huge and −∞ scores, and parents are better
      than the average.
    - Crossover, mutation: results are new arrays of the right shape and dtype for each space in
      `spaces`, with real, periodic and binary genes. Schedules are valid.
    - Reflex: state and inputs change in place, stay finite, and have the population as their first
      axis, also if observations outside `needs` are missing. Options may be arrays. The C code
      reads only options, state and observations that exist.
    - Plot, exporter: declarations are complete, no option has the name of an option of the command,
      and the product made twice has the same bytes.
    - Preset: the file can be read, its first individuals move, and a second population can be bred.

    Args:
        kind: kind of plugin, such as 'organism'; 'experiments' for a preset.
        name: name of the plugin or preset.
        options: options to override.
        seconds: timeout in seconds.

    Raises:
        PluginError: the plugin does not exist, or several packages register the name.
        GaitsimError: `seconds` is not a valid timeout.
    """
    (report,) = examine_in_processes([find(kind, name)], options, seconds=seconds)
    return report


def check_package(reference: str | Path | None, *, seconds: float = SECONDS) -> list[Report]:
    """Check all plugins and presets of a package.

    Args:
        reference: name of an installed plugin or package, or folder of a package, which need not
            be installed; None for all installed plugins and presets.
        seconds: timeout per plugin, s.

    Raises:
        GaitsimError: the name is unknown, or the folder does not contain a package with plugins.
    """
    with select_plugins(reference) as found:
        return list(check_plugins(found, seconds=seconds))


def check_plugins(found: PluginSelection, *, seconds: float = SECONDS) -> Iterator[Report]:
    """Check plugins one after another; yield each report as soon as it is ready."""
    for report in examine_in_processes(found.entries, seconds=seconds, path=found.path):
        duplicate = check_unique_name(report.entry)
        findings = (duplicate, *report.findings) if duplicate else report.findings
        yield replace(report, findings=findings)
