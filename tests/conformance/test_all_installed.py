"""Every plugin and preset that is installed is held to what a third party's is."""

import pytest
from gaitsim.testing.examine import examine

from gaitsim.registry import EXPERIMENTS, PLUGINS, entries, find
from gaitsim.testing import check_package

ALL = [(kind, name) for kind in (*PLUGINS, EXPERIMENTS) for name in entries(kind)]


@pytest.fixture(scope="module")
def reports():
    """One check of them all, in the processes that `gaitsim plugins check` uses."""
    found = check_package(None)
    return {(report.entry.kind, report.entry.name): report for report in found}


@pytest.mark.slow  # examining all of them takes half a minute
@pytest.mark.parametrize(("kind", "name"), ALL, ids=lambda part: part)
def test_it_conforms(reports, kind, name):
    report = reports[kind, name]
    assert report.ok, report
    # A busy machine is slow; all other advice is heeded by what gaitsim ships.
    heeded = {finding.rule for finding in report.advice} - {"speed", "import time"}
    assert not heeded or report.entry.package != "gaitsim", report


OTHER_OPTIONS = [
    pytest.param("spider", {"encoding": "cpg"}, marks=pytest.mark.slow),
    ("spider", {"encoding": "recurrence"}),
    ("spider", {"symmetry": "alternating", "frequency": 5.0}),
    ("millipede", {"codec": "unsigned", "pairs": 7}),
    pytest.param(
        "fly",
        {"wings": "asymmetric", "trials": 3, "hidden": [5], "duration": 0.5},
        marks=pytest.mark.slow,
    ),
    pytest.param("walker", {"encoding": "cpg", "legs": 2, "duration": 0.5}, marks=pytest.mark.slow),
    pytest.param(
        "walker",
        {"world": {"unevenness": 0.05}, "symmetry": "alternating", "duration": 0.5},
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize(("name", "options"), OTHER_OPTIONS, ids=str)
def test_bodies_conform_with_other_options(name, options):
    report = examine(find("organism", name), options)
    assert report.ok, report
