"""Searches that begin at gaits from files."""

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim.gait.from_file import start_from_gait
from gaitsim.gait.gait_files import Gait, GaitFile, read_gait, write_gait

RATE = 50.0


@pytest.fixture
def quadruped():
    return load_experiment("quadruped", {"organism.duration": 2.0})


def sines(experiment, seconds, frequency=1.25):
    """Return joint angles around the standing pose, (frames, joints) rad."""
    rest = np.asarray(experiment.organism.standing_pose())
    rng = np.random.default_rng(0)
    time = np.arange(round(seconds * RATE) + 1)[:, None] / RATE
    amplitude, phase = rng.uniform(0.05, 0.2, len(rest)), rng.uniform(0, 6, len(rest))
    return rest + amplitude * np.sin(2 * np.pi * frequency * time + phase)


def file_of(experiment, angles, path):
    names = tuple(experiment.organism.joint_names())
    write_gait(Gait(angles, names, RATE, 0, 0.0), path, "csv")
    return read_gait(path)


def test_sines_are_fitted_exactly(quadruped, tmp_path):
    angles = sines(quadruped, 4.0)
    found = start_from_gait(quadruped, file_of(quadruped, angles, tmp_path / "a.csv"))
    assert "1.25 strides per second" in found.about
    assert "within 0.0°" in found.about
    organism = found.experiment.organism
    assert organism.encoding == "sine"
    assert organism.reflexes == quadruped.organism.reflexes
    assert found.experiment.space().contains(found.individual.genome[None])
    moved = found.individual.joint_angles[50:]
    shifts = [np.abs(moved - angles[lag : lag + len(moved)]).max() for lag in range(80)]
    assert min(shifts) < 0.02  # of the commands, which begin slowly


def test_one_cycle_is_repeated(quadruped, tmp_path):
    angles = sines(quadruped, 0.8)  # one stride of 1.25 Hz
    found = start_from_gait(quadruped, file_of(quadruped, angles, tmp_path / "a.csv"))
    assert "1.25 strides per second, taken as one cycle" in found.about


def test_bodies_that_cannot_fit_say_so(tmp_path):
    spider = load_experiment("spider")
    angles = np.zeros((60, 24)) + 0.1 * np.sin(np.arange(60) / 4)[:, None]
    file = GaitFile(tmp_path / "a.csv", angles, 30.0, tuple(spider.organism.joint_names()))
    with pytest.raises(GaitsimError, match="a search cannot begin at a gait from a file"):
        start_from_gait(spider, file)


def test_a_run_begins_at_the_file(quadruped, tmp_path, gaitsim):
    file_of(quadruped, sines(quadruped, 2.0), tmp_path / "a.csv")
    small = ("--generations", 1, "--population", 6, "--set", "organism.duration=1")
    done = gaitsim("run", "quadruped", "--from", tmp_path / "a.csv", *small)
    assert "Played, the file scores" in done.stderr
    text = (tmp_path / "runs/quadruped/experiment.toml").read_text(encoding="utf-8")
    assert 'encoding = "sine"' in text
