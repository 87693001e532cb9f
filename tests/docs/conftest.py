"""A fixture with the runs that pages and `--help` name."""

from collections.abc import Callable
from pathlib import Path

import pytest
from reader import LONG


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the views that pages save out of the settings of the user."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """A function that evolves a preset once, with few individuals, and returns the run."""
    import gaitsim as gs

    folder = tmp_path_factory.mktemp("runs")

    def run_of(preset: str) -> Path:
        if not (folder / preset).exists():
            options = {"generations": 2}
            if preset in LONG:
                options = LONG[preset]
            elif "millipede" not in preset:  # which is quick, and not every size does for it
                options["population"] = 20
            for _ in gs.evolve(preset, **options, out=folder / preset):
                pass
        return folder / preset

    return run_of
