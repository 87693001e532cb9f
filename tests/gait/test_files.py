import csv

import numpy as np
import pytest
from scipy.io import loadmat

from gaitsim.contracts import Channel
from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import gait_of, write_gait


def read_csv(path):
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=np.float64)


@pytest.fixture
def written(spider_run, tmp_path):
    """The champion's gait, and the files of it by format."""
    gait = gait_of(spider_run.individual())
    paths = {format: tmp_path / f"gait.{format}" for format in ("mat", "csv", "npz")}
    for format, path in paths.items():
        write_gait(gait, path, format)
    return gait, paths


def test_the_gait_has_the_joint_angles_of_the_champion(spider_run):
    gait = gait_of(spider_run.individual())
    best = spider_run.individual()
    generation, score, genome = best.generation, best.score, best.genome
    assert (gait.generation, gait.score, gait.frame_rate) == (generation, score, 30.0)
    assert gait.angles.shape == (300, 24)
    assert gait.angles.dtype == np.float64
    angles = spider_run.experiment.organism.move(genome[None])["joint_angles"][0]
    assert np.array_equal(gait.angles, angles.astype(np.float64))
    assert np.abs(gait.angles).max() > 0
    assert gait_of(spider_run.individual(2)).generation == 2


def test_matlab_fields_are_those_of_the_original_program(written):
    gait, paths = written
    mat = loadmat(paths["mat"])
    assert mat["bestGait"].dtype == np.float64
    assert mat["bestGait"].shape == (300, 24)
    assert mat["bestGait"].tobytes() == np.ascontiguousarray(gait.angles).tobytes()
    assert mat["frameRate"].tolist() == [[30.0]]
    assert mat["frameRate"].dtype == np.float64
    assert mat["jointNames"].dtype == object  # a cell array
    assert mat["jointNames"].shape == (24, 1)
    assert [cell.item() for cell in mat["jointNames"].ravel()] == list(gait.joint_names)
    assert mat["units"].tolist() == ["rad"]
    assert mat["generation"].item() == gait.generation
    assert mat["score"].item() == gait.score


def test_a_table_has_seconds_and_a_column_a_joint(written):
    gait, paths = written
    header, table = read_csv(paths["csv"])
    assert header == ["time_s", *gait.joint_names]
    assert header[1:4] == ["L1 coxa", "L1 femur", "L1 tibia"]
    assert table.shape == (300, 25)
    assert table[:, 0].tolist() == [frame / 30 for frame in range(300)]
    assert b"\r" not in paths["csv"].read_bytes()


def test_a_body_without_joint_angles_is_an_error(puppet_run, puppets, monkeypatch):
    run = puppet_run()
    assert run.experiment
    monkeypatch.setattr(puppets.Puppet, "channels", {"reach": Channel((), "m", "")})
    with pytest.raises(GaitsimError, match="puppet"):
        gait_of(run.individual())
