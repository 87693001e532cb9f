"""From a robot's file to a run that no longer needs the file."""

import json
from importlib.resources import files

import pytest

from gaitsim.experiment import load_experiment
from gaitsim.storage.snapshot import RunSnapshot

MODELS = files("gaitsim_robot") / "models"
SMALL = ("--population", 4, "--set", "organism.duration=1")


@pytest.fixture
def robot(tmp_path):
    """Return the path of a robot's file in the test's folder."""
    path = tmp_path / "my_robot.xml"
    path.write_bytes((MODELS / "quadruped.xml").read_bytes())
    return path


def test_a_check_shows_what_was_found(gaitsim, robot, tmp_path):
    done = gaitsim("robots", "check", robot, "--json", "--model-out", "whole.xml")
    found = json.loads(done.stdout)
    assert list(found["facts"]["Legs"]) == ["L1", "R1", "L2", "R2"]
    assert found["facts"]["Body"]["mass"].startswith("1.7")
    assert "N m" in found["facts"]["Servos"]["all"]
    assert "% of the torque" in found["facts"]["Servos"]["standing"]
    assert load_experiment(str(tmp_path / "whole.xml")).organism.joint_names() == (
        load_experiment("robot").organism.joint_names()
    )
    assert "quadruped" in gaitsim("robots", "list").stdout
    before = robot.read_bytes()
    for out in (robot, "whole.xml", "notes.txt"):
        assert gaitsim("robots", "check", robot, "--model-out", out, code=2).stderr
    assert robot.read_bytes() == before


@pytest.mark.slow
@pytest.mark.parametrize("text", ["", "<mujoco/>", "<robot name='r'><link name='a'/></robot>"])
def test_invalid_robots_are_reported_with_their_file(gaitsim, robot, text):
    robot.write_text(text)
    assert "my_robot.xml" in gaitsim("run", "my_robot.xml", code=2).stderr
    assert "my_robot.xml" in gaitsim("robots", "check", "my_robot.xml", code=1).stderr


@pytest.mark.slow  # 6 s
def test_a_run_does_not_need_the_file_after_its_start(gaitsim, program, robot, tmp_path):
    gaitsim("run", "my_robot.xml", "--generations", 2, *SMALL, "--workers", 1)
    gaitsim("run", "my_robot.xml", "--generations", 4, *SMALL, "--out", "runs/whole")
    robot.unlink()
    program("resume", "my_robot", "--generations", 4, "--workers", 2)
    half, whole = (RunSnapshot(tmp_path / "runs" / name) for name in ("my_robot", "whole"))
    assert half.fingerprint() == whole.fingerprint()
    for origin in json.loads((half.path / "provenance.json").read_text()):
        assert "mujoco" in origin["parts"]
        assert any(key.startswith("organism.model ") for key in origin["parts"])
    gaitsim("verify", "my_robot", "--all")
    gaitsim("fork", "my_robot", "--generations", 9)
    gaitsim("export", "my_robot-2", "--format", "csv", "--out", "gait.csv")
    names = half.experiment.organism.joint_names()
    assert (tmp_path / "gait.csv").read_text().splitlines()[0].split(",")[1:] == list(names)
    gaitsim("run", "runs/whole/experiment.toml", "--generations", 2, "--dask", "local")
    output = gaitsim("differences", "my_robot", "whole").stdout
    assert len(output) < 20_000
