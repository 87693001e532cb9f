"""Exports of the bundled bodies, in Python."""

from pathlib import Path

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.playing import play
from gaitsim.experiment import with_overrides
from gaitsim.individual import Individual


@pytest.fixture
def walker():
    """Return a walker that plays the given angles, (frames, joints) rad."""

    def moved(angles):
        experiment = gs.load_experiment("walker")
        return Individual.of_motion(experiment, play(experiment, angles[None]), Path("x.csv"))

    return moved


def test_a_notice_reports_a_fall_in_the_simulation(walker, tmp_path):
    folded = np.linspace(0, 1.2, 60)[:, None] * np.array([1.0, -1.0, 1.0, -1.0])
    fallen = gs.export(walker(np.vstack([folded, *[folded[-1:]] * 60])), tmp_path / "a", "ros2")
    assert any("falls after" in notice for notice in fallen.notices)
    standing = gs.export(walker(np.zeros((20, 4))), tmp_path / "b", "ros2")
    assert standing.notices == ()


def test_a_robot_stands_with_its_servos_at_their_centre(tmp_path):
    experiment = with_overrides(gs.load_experiment("quadruped"), {"organism.duration": 4})
    middle = experiment.organism.genome_space()
    genome = (middle.lower + middle.upper) / 2
    moved = experiment.organism.move(genome[None])
    individual = Individual.of_motion(experiment, moved, Path("x.csv"))
    done = gs.export(individual, tmp_path / "walk", "arduino")
    assert "a loop of" in done.summary
    header = (tmp_path / "walk" / "gait.h").read_text()
    assert "STANDING[JOINTS] PROGMEM = {" + ", ".join(["1500"] * 12) + "}" in header
    # The servo of the preset is a bus servo, whose centre is 2048.
    gs.export(individual, tmp_path / "x.csv", "feetech")
    assert (tmp_path / "x.csv").read_text().splitlines()[1] == "0" + ",2048" * 12


def test_a_notice_names_servos_whose_speed_is_not_checked(walker, tmp_path):
    individual, file = walker(np.zeros((20, 4))), tmp_path / "robot.toml"
    gs.export(individual, tmp_path / "walk", "arduino", calibration_template=file)
    text = file.read_text()

    def notices(text):
        file.write_text(text)
        return gs.export(individual, tmp_path / "walk", "arduino", calibration=file).notices

    (notice,) = notices(text)
    assert "and 3 more is unknown and was not checked" in notice
    (notice,) = notices(text.replace('servo = ""', 'servo = "mg995"', 3))
    assert "more" not in notice
    assert notices(text.replace('servo = ""', "speed = 300.0")) == ()


def test_unknown_formats_and_options_are_refused(walker, tmp_path):
    individual = walker(np.zeros((20, 4)))
    with pytest.raises(GaitsimError, match="unknown format 'arduno'"):
        gs.export(individual, tmp_path / "x", "arduno")
    with pytest.raises(GaitsimError, match="unknown option"):
        gs.export(individual, tmp_path / "x", "ros2", sped=2)
    with pytest.raises(GaitsimError, match="unknown option of 'ros2' 'clip'") as error:
        gs.export(individual, tmp_path / "x", "ros2", clip=True)
    assert error.value.remedy == "omit it, or choose arduino or dynamixel or feetech or servo"


def test_none_stands_for_the_default_of_an_option(walker, tmp_path):
    individual = walker(np.zeros((20, 4)))
    gs.export(individual, tmp_path / "a.csv", "servo", speed=None, calibration=None, clip=None)
    gs.export(individual, tmp_path / "b.csv", "servo")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    gs.export(individual, tmp_path / "c.csv", calibration=None)
