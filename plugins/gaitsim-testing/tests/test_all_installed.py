"""Every plugin and preset that is installed is held to what a third party's is."""

import json
import subprocess
import sys

import pytest

from gaitsim.registry import COMMANDS, EXPERIMENTS, PLUGINS
from gaitsim_testing.checking import check_plugins
from gaitsim_testing.packages import PluginSelection, select_plugins


@pytest.mark.slow  # checking all of them takes a minute
@pytest.mark.parametrize("kind", [*PLUGINS, EXPERIMENTS, COMMANDS])
def test_they_conform(kind):
    with select_plugins(None) as found:
        entries = tuple(entry for entry in found.entries if entry.kind == kind)
    checked = list(check_plugins(PluginSelection(entries)))
    assert [one.entry for one in checked] == [*entries]
    for one in checked:
        assert one.broken == []
        # A busy machine is slow; all other advice is heeded by what gaitsim ships.
        heeded = [
            text for text in one.advice if "each further" not in text and "import" not in text
        ]
        assert not heeded or one.entry.package != "gaitsim", one


OTHER_OPTIONS = [
    ("spider", {"encoding": "cpg"}),
    ("spider", {"encoding": "recurrence"}),
    ("spider", {"symmetry": "alternating", "frequency": 5.0}),
    ("millipede", {"codec": "unsigned", "pairs": 7}),
    ("fly", {"wings": "asymmetric", "trials": 3, "hidden": [5], "duration": 0.5}),
    ("walker", {"encoding": "cpg", "legs": 2, "duration": 0.5}),
    ("walker", {"world": {"unevenness": 0.05}, "symmetry": "alternating", "duration": 0.5}),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), OTHER_OPTIONS, ids=str)
def test_bodies_conform_with_other_options(name, options, tmp_path):
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", tmp_path]
    command += [f"--gaitsim=organism:{name}", "--gaitsim-options", json.dumps(options)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "passed" in done.stdout
