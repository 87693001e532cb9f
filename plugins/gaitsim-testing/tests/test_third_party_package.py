"""A package as a third party ships it, installed into a fresh environment and used there."""

from pathlib import Path

import pytest
from environment import Environment

from gaitsim_testing.checking import check_plugins
from gaitsim_testing.packages import select_plugins

ROWER = Path(__file__).parents[3] / "tests" / "fixtures" / "gaitsim-rower"


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """An environment with the package, from a wheel as a user gets it."""
    made = Environment(tmp_path_factory.mktemp("environment") / "venv")
    made.run(["pip", "install", ROWER], Path("/"))
    return made


@pytest.mark.slow
def test_it_passes_before_it_is_installed():
    with select_plugins(ROWER) as found:
        checked = list(check_plugins(found))
    assert [one.entry.kind for one in checked] == [
        "organism", "fitness", "selection", "crossover", "mutation", "experiments", "experiments",
    ]  # fmt: skip
    for one in checked:
        assert (one.broken, one.advice) == ([], [])
        assert one.entry.source == "gaitsim-rower 2.3.0"


@pytest.mark.slow
def test_an_installed_package_passes_in_full(environment, tmp_path):
    listed = environment.run(["gaitsim", "plugins", "list"], tmp_path).stdout
    assert listed.count("gaitsim-rower 2.3.0") == 5
    checked = environment.run(
        ["gaitsim", "plugins", "check", "gaitsim-rower", "--strict"], tmp_path
    )
    assert checked.stdout.count("✓") == 7
    shown = environment.run(["gaitsim", "plugins", "show", "rower"], tmp_path).stdout
    assert "force of an oar" in shown


@pytest.mark.slow
def test_runs_of_a_missing_package_name_it(environment, tmp_path, gaitsim):
    environment.run(["gaitsim", "run", "rower", "--generations", "2"], tmp_path)
    done = gaitsim("resume", "rower", "--generations", "5", code=2)
    assert "unknown organism plugin 'rower'" in done.stderr
