"""A fixture with the runs that pages and `--help` name."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from filelock import FileLock
from reader import LONG, is_robot, robot_options


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep what pages save out of the settings of the user."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """A function that evolves a preset once, with few individuals, and returns the run."""
    import gaitsim as gs

    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # which all workers share
    folder /= "documented"
    folder.mkdir(exist_ok=True)

    def run_of(preset: str) -> Path:
        with FileLock(folder / f"{preset}.lock"):
            if not (folder / preset).exists():
                options: dict[str, Any] = {"generations": 2}
                if preset in LONG:
                    options = LONG[preset]
                elif is_robot(preset):
                    options["population"] = 20 if "atlas" in preset else 4
                    options |= {"set": robot_options(preset), "workers": 1}
                elif "millipede" not in preset:  # which is quick, and not every size does for it
                    options["population"] = 20
                for _ in gs.evolve(preset, **options, out=folder / preset):
                    pass
        return folder / preset

    return run_of
