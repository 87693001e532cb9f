"""A run folder of the previous format is rejected with one message."""

import json
import shutil
from pathlib import Path

import pytest

OLD = Path(__file__).parents[1] / "fixtures" / "run-format-1"  # written by gaitsim 0.1.0


@pytest.fixture
def old(tmp_path):
    return Path(shutil.copytree(OLD, tmp_path / "runs" / "old"))


def files(path):
    return {item.name: item.read_bytes() for item in path.rglob("*") if item.is_file()}


@pytest.mark.parametrize("command", ["show", "resume", "verify", "fork"])
def test_a_command_says_who_wrote_it_and_changes_nothing(gaitsim, old, command):
    before = files(old)
    done = gaitsim(command, "old", code=2)
    assert "was written by gaitsim 0.1.0 in the older format 1" in done.stderr
    assert "start a new run" in done.stderr
    after = {name: data for name, data in files(old).items() if not name.startswith(".lock")}
    assert after == before


def test_a_run_does_not_start_from_its_champion(gaitsim, old):
    for start in ("old", old / "champions" / "generation-000003.pickle"):
        done = gaitsim("run", "millipede", "--from", start, code=2)
        assert "was written by gaitsim 0.1.0" in done.stderr


def test_it_is_listed_as_such(gaitsim, old):
    (row,) = map(json.loads, gaitsim("runs", "--json").stdout.splitlines())
    assert (row["run"], row["state"]) == ("old", "older format")
    assert "older format" in gaitsim("runs").stdout
