"""Fixtures: runs of puppets, which other processes can import."""

import asyncio
import os
from pathlib import Path

import pytest

from gaitsim.storage.creation import create_run

PUPPETS = Path(__file__).parents[1] / "puppets"


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, puppets):
    """Change to the test's folder; other processes can import the puppets, too."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(PUPPETS), prepend=os.pathsep)


@pytest.fixture
def new_run(puppet):
    """A function that creates the folder of a run of puppets, with overrides."""

    def new_run(out="run", *overrides, generations=30):
        given = (f"evolution.generations={generations}", *overrides)
        return create_run(puppet(*given), Path(out))

    return new_run


@pytest.fixture
def wait():
    """A coroutine that waits until a condition holds."""

    async def wait(holds, seconds=60):
        async with asyncio.timeout(seconds):
            while not holds():
                await asyncio.sleep(0.01)

    return wait
