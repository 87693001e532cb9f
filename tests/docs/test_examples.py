"""The examples of each `--help` work as printed."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from reader import FOUND, HELP, does_all


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", [path for path in FOUND if path in HELP], ids=lambda path: path.name
)
def test_the_examples_of_a_command_run(
    path: Path, runs: Callable[[str], Path], tmp_path: Path, gaitsim: Callable[..., SimpleNamespace]
) -> None:
    does_all(path, tmp_path, runs, gaitsim)
