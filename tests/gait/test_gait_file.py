"""Gait files: exported gaits are read back, and other files are rejected."""

import io
from pathlib import Path

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait, GaitFile, play_gait, read_gait, write_gait

NAMES = ("L1 coxa", "naïve, joint", "c")
ANGLES = np.array([[0.0, 0.1, -0.2], [0.05, 0.125, -0.25], [0.1, 1 / 3, 0]])


@pytest.mark.parametrize("format", ["csv", "npz", "mat"])
def test_an_exported_gait_is_read_back(format, tmp_path):
    path = tmp_path / f"gait.{format}"
    write_gait(Gait(ANGLES, NAMES, 25.0, 7, 1.5), path, format)
    file = read_gait(path)
    assert file.angles.tolist() == ANGLES.tolist()
    assert file.joint_names == NAMES
    assert file.frame_rate == pytest.approx(25)


def test_a_matlab_file_does_not_contain_the_time(tmp_path):
    path = tmp_path / "gait.mat"
    write_gait(Gait(ANGLES, NAMES, 25.0, 7, 1.5), path, "mat")
    assert path.read_bytes()[:116].rstrip() == b"MATLAB 5.0 MAT-file, created by gaitsim"


def test_a_csv_file_names_joints_in_metres(tmp_path):
    gait = Gait(ANGLES, NAMES, 25.0, 7, 1.5, slides=("c",))
    write_gait(gait, tmp_path / "gait.csv", "csv")
    header = (tmp_path / "gait.csv").read_text().splitlines()[0]
    assert header == 'time_s,L1 coxa,"naïve, joint",c [m]'
    assert read_gait(tmp_path / "gait.csv").joint_names == NAMES
    assert gait.units == "radians; metres of c"


def test_the_fields_of_an_imitator_are_read(tmp_path):
    path = tmp_path / "imitator.NPZ"
    with path.open("wb") as file:
        np.savez(file, joint_angles=ANGLES.astype(np.float32), frame_rate=30.0, w1=np.ones(9))
    found = read_gait(path)
    assert found.angles.dtype == np.float64
    assert (found.frame_rate, found.joint_names) == (30.0, ())


def npz(**fields):
    packed = io.BytesIO()
    np.savez(packed, **fields)
    return packed.getvalue()


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.txt", b"", "does not have the extension of a gait file"),
        ("a.npz", b"", "is not a gait file"),
        ("a.npz", npz(other=ANGLES), "neither joint_angles nor bestGait"),
        ("a.npz", npz(joint_angles=np.array([[{}]], dtype=object)), "allow_pickle"),
        ("a.npz", npz(joint_angles=ANGLES[:1]), "and shape (1, 3)"),
        ("a.npz", npz(joint_angles=ANGLES * np.nan), "not all finite"),
        ("a.npz", npz(joint_angles=ANGLES, frame_rate=0.0), "frame rate is 0"),
        ("a.npz", npz(joint_angles=ANGLES, joint_names=["a"]), "names 1 of its 3 joints"),
        ("a.mat", b"MATLAB 5.0 MAT-file" + bytes(200), "is not a gait file"),
        ("a.csv", b"", "first column is not time_s"),
        ("a.csv", b"time_s,a\n0,x\n1,2", "could not convert"),
        ("a.csv", b"time_s,a\n0,1\n0,2\n", "do not ascend"),
    ],
)
def test_other_files_are_rejected(name, content, says, tmp_path):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(GaitsimError) as told:
        read_gait(path)
    assert says in told.value.what
    assert str(path) in told.value.what
    assert "time_s" in told.value.allowed


def test_files_too_large_are_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr("gaitsim.gait.gait_files.LARGEST", 2000)
    packed = tmp_path / "packed.npz"
    np.savez_compressed(packed, joint_angles=np.zeros((100, 3)))
    assert packed.stat().st_size < 2000
    with pytest.raises(GaitsimError, match="2,000 bytes"):
        read_gait(packed)
    packed.write_bytes(bytes(2001))
    with pytest.raises(GaitsimError, match="too large"):
        read_gait(packed)


def test_joints_are_put_in_the_bodys_order():
    file = GaitFile(Path("a.csv"), ANGLES, None, ("c", "a", "b"))
    assert file.in_order(("a", "b", "c")).tolist() == ANGLES[:, [1, 2, 0]].tolist()
    unnamed = GaitFile(Path("a.csv"), ANGLES, None, ())
    assert unnamed.in_order(("a", "b", "c")) is ANGLES
    for joints in (("a", "b", "d"),):
        with pytest.raises(GaitsimError, match=r"the joint .*, which this body does not have"):
            file.in_order(joints)
    with pytest.raises(GaitsimError, match="has 3 joints, but this body has 4"):
        file.in_order(("a", "b", "c", "d"))
    with pytest.raises(GaitsimError, match="has 3 joints, but this body has 2"):
        unnamed.in_order(("a", "b"))


def test_a_gait_at_another_rate_is_interpolated_to_that_of_the_body(spider, reference):
    names = spider.organism.joint_names()
    angles = reference("wave")
    for rate in (30.0, 30.01, None):
        individual = play_gait(GaitFile(Path("wave.npz"), angles, rate, names), spider)
        assert individual.title == "wave.npz on the spider"
        assert individual.score == pytest.approx(0.0998, abs=1e-3)
        assert (individual.generation, individual.genome) == (0, None)
    between = (angles[:-1] + angles[1:]) / 2
    finer = np.stack([angles[:-1], between], axis=1).reshape(-1, angles.shape[1])
    played = play_gait(GaitFile(Path("wave.npz"), finer, 60.0, names), spider)
    np.testing.assert_allclose(played.joint_angles, angles[:-1], atol=1e-6)
    coarser = play_gait(GaitFile(Path("wave.npz"), angles[::2], 15.0, names), spider)
    np.testing.assert_allclose(
        coarser.joint_angles[1::2], (angles[:-2:2] + angles[2::2]) / 2, atol=1e-6
    )
    for absurd in (1e-3, 1e5):
        with pytest.raises(GaitsimError, match="frames per second"):
            play_gait(GaitFile(Path("wave.npz"), angles, absurd, names), spider)
