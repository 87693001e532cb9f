"""Runs of puppets, which processes can import."""

import asyncio
import os
from pathlib import Path

import pytest

from gaitsim.runs.files.folder import create_run

PUPPETS = Path(__file__).parents[1] / "puppets"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, puppets):
    """In the test's folder; processes find the puppets as well."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(PUPPETS), prepend=os.pathsep)


@pytest.fixture
def begun(puppet):
    """Makes the folder of a run of puppets, with the overrides asked for."""

    def begun(out="run", *overrides, generations=30):
        given = (f"evolution.generations={generations}", *overrides)
        return create_run(puppet(*given), Path(out))

    return begun


@pytest.fixture
def wait():
    """Waits in a coroutine until something holds."""

    async def wait(holds, seconds=60):
        async with asyncio.timeout(seconds):
            while not holds():
                await asyncio.sleep(0.01)

    return wait
