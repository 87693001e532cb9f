"""A robot's file in place of an experiment."""

import json
from hashlib import sha256

import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.experiment.loading import experiment_name


@pytest.mark.parametrize("name", ["My robot.shape", "My robot.SHAPE"])
def test_a_file_takes_the_preset_of_the_body_that_reads_it(shaped, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("<a/>\n<b/>")
    experiment = load_experiment(name, {"seed": 7})
    assert experiment.organism.shape == "<a/>\n<b/>"
    assert (experiment.name, experiment.seed) == ("My robot", 7)
    assert load_experiment(f"{tmp_path}/{name}", {"seed": 7}) == experiment
    same = {"seed": 7, "organism.shape": name, "name": "My robot"}
    assert load_experiment("cube", same) == experiment
    search = gs.evolve(name, population=4, generations=2)
    assert [generation.number for generation in search] == [1, 2]


def test_what_the_body_does_not_accept_is_one_message(shaped, tmp_path, monkeypatch, gaitsim):
    said = gaitsim("run", "none.shape", code=2).stderr
    assert "file not found: none.shape" in said
    (tmp_path / "a.shape").write_bytes(b"\xff")
    said = gaitsim("run", "a.shape", code=2).stderr
    assert "a.shape" in said
    assert "command line, key organism.shape" in said
    said = gaitsim("run", "a.sdf", code=2).stderr
    assert ".shape" in said
    with pytest.raises(GaitsimError, match="file not found"):
        gs.evolve("none.shape")


def test_a_file_runs_and_is_not_needed_again(shaped, tmp_path, gaitsim):
    (tmp_path / "a.shape").write_text("<a/>\n<b/>\n")
    gaitsim("run", "a.shape", "--generations", 2, "--workers", 1)
    (tmp_path / "a.shape").unlink()
    gaitsim("resume", "a", "--generations", 3, "--workers", 1)
    gaitsim("verify", "a")
    origin = json.loads((tmp_path / "runs/a/provenance.json").read_text())[0]["parts"]
    assert origin["organism.shape " + sha256(b"<a/>\n<b/>\n").hexdigest()] == "SHA-256"
    gaitsim("fork", "a", "--generations", 9)
    assert "shape = '''\n<a/>\n<b/>\n'''" in (tmp_path / "runs/a-2/experiment.toml").read_text()
    shown = gaitsim("experiments", "show", "runs/a-2/experiment.toml").stdout
    assert "<b/>\n'''" in shown


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("spot", "spot"),
        ("a:b*c", "a-b-c"),
        ("..", "experiment"),
        ("ä" * 300, "ä" * 50),
    ],
)
def test_an_experiment_is_named_after_its_file(stem, name, tmp_path):
    assert experiment_name(tmp_path / f"{stem}.urdf") == name
