"""Fixtures: runs of puppets, which other processes can import."""

import asyncio
from pathlib import Path

import pytest

from gaitsim.storage.creation import create_run


@pytest.fixture(autouse=True)
def _here(here):
    """Change to the test's folder; other processes can import the puppets, too."""


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
