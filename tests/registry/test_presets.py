"""Presets are read as text from any package, without importing it."""

import sys
import tomllib

import pytest

from gaitsim.errors import PluginError
from gaitsim.experiment import load_experiment
from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.registry.loading import read_preset

RAISES = "raise RuntimeError('imported')"


@pytest.mark.parametrize("name", entries(EXPERIMENTS))
def test_each_preset_is_whole_and_carries_its_name(name):
    experiment = load_experiment(name)
    assert experiment.name == name
    assert experiment.description
    assert tomllib.loads(read_preset(name))["name"] == name


@pytest.mark.parametrize("package", ["fakes", "fakes.deep.experiments"])
def test_a_preset_is_read_without_importing_its_package(install, package):
    parts = package.split(".")
    inits = {f"{'/'.join(parts[:n])}/__init__.py": RAISES for n in range(1, len(parts) + 1)}
    files = {
        **inits,
        f"{'/'.join(parts)}/hop.toml": "\ufeffname = 'hop'\n",
        "fakes-1.0.dist-info/entry_points.txt": f"[gaitsim.experiments]\nhop = {package}\n",
    }
    install("fakes", files=files)
    assert read_preset("hop") == "name = 'hop'\n"
    assert "fakes" not in sys.modules


@pytest.mark.parametrize(
    ("files", "target", "reason"),
    [
        ({"fake/__init__.py": ""}, "fake", "no file hop.toml"),
        ({"fake/__init__.py": "", "fake/hop.toml": b"\xe9"}, "fake", "UnicodeDecodeError"),
        ({}, "fake", "No module named 'fake'"),
        ({}, "", "being read"),
        ({"fake.py": ""}, "fake", "experiments 'hop' of package"),  # a module, not a package
    ],
)
def test_a_preset_that_cannot_be_read_names_its_package(install, files, target, reason):
    points = f"[gaitsim.experiments]\nhop = {target}\n"
    install("fake", files={**files, "fake-1.0.dist-info/entry_points.txt": points})
    with pytest.raises(PluginError) as raised:
        read_preset("hop")
    assert "package fake 1.0" in str(raised.value)
    assert reason in str(raised.value)
    assert read_preset("spider")
