"""`measures.json`: the measures of a champion, stored with its run."""

import json

import pytest
from run_helpers import evolve_run

from gaitsim.storage import measured
from gaitsim.storage.creation import create_run
from gaitsim.storage.measured import Measured, read_measured
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import verify_run

FILE = "measures.json"


@pytest.fixture
def run(puppet, tmp_path):
    path = create_run(puppet(), tmp_path / "run")
    evolve_run(path, 3)
    return RunSnapshot(path)


def test_the_measures_of_the_champion_are_those_of_its_motion(run):
    champion = run.individual()
    stored = read_measured(run.path, champion)
    assert stored == Measured.of(champion)
    assert stored.measures == champion.measurements != {}


def test_measures_of_another_champion_are_not_used_and_are_replaced(run):
    evolve_run(run.path, None)
    champion = RunSnapshot(run.path).individual()
    assert read_measured(run.path, champion) == Measured.of(champion)
    content = json.loads((run.path / FILE).read_text())
    (run.path / FILE).write_text(json.dumps(content | {"generation": champion.generation + 1}))
    assert read_measured(run.path, champion) is None
    (run.path / FILE).write_text("{")
    assert read_measured(run.path, champion) is None


def test_a_champion_whose_measures_are_stored_is_not_simulated_again(run, monkeypatch):
    monkeypatch.setattr(measured, "Measured", None)
    measured.write_measured(run.path, run.individual())


@pytest.mark.parametrize(
    "change",
    [
        lambda content: content | {"generation": 0},
        lambda content: content | {"score": content["score"] + 1},
        lambda content: content | {"warnings": ["It chatters."]},
        lambda content: content | {"measures": {}},
        lambda content: "nonsense",
    ],
)
def test_verify_finds_changed_measures(run, change):
    assert verify_run(run).identical
    content = json.loads((run.path / FILE).read_text())
    (run.path / FILE).write_text(json.dumps(change(content)))
    verdict = verify_run(RunSnapshot(run.path))
    assert [one.file for one in verdict.differences] == [FILE]
