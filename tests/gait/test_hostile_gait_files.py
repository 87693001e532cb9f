"""Limits of untrusted gait files; `tests/test_readers.py` reads files with random changes."""

import io
import os
import struct
import zipfile

import numpy as np
import pytest
from readers import ANGLES, NAMES, matlab, packed

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import MOST_FRAMES, Gait, read_gait, write_gait
from gaitsim.gait.matlab import read_matlab
from gaitsim_imitation import load_imitator


def test_a_matlab_file_is_unpacked_within_bounds(tmp_path, monkeypatch):
    path = tmp_path / "gait.mat"
    path.write_bytes(packed(matlab("5", junk=np.zeros(10_000))))
    monkeypatch.setattr("gaitsim.gait.gait_files.LARGEST", 5000)
    assert read_gait(path).angles.shape == ANGLES.shape  # other variables stay packed
    path.write_bytes(packed(matlab("5", bestGait=np.zeros((1000, 3)))))
    with pytest.raises(GaitsimError, match="unpacks to too many bytes"):
        read_gait(path)
    twice = packed(matlab("5", bestGait=np.zeros((150, 3))))  # 3.6 kB
    path.write_bytes(twice + twice[128:])
    with pytest.raises(GaitsimError, match="unpacks to too many bytes"):
        read_gait(path)


@pytest.mark.parametrize("version", ["4", "5"])
def test_the_length_of_names_is_limited(version, tmp_path):
    path = tmp_path / "gait.mat"
    for names in ("a" * 60_000, np.array(["a" * 60_000] * 2, dtype=object)):
        if isinstance(names, str) or version == "5":
            path.write_bytes(matlab(version, jointNames=names))
            with pytest.raises(GaitsimError, match="a string has more than 50,000"):
                read_gait(path)


@pytest.mark.parametrize("suffix", ["npz", "csv", "mat"])
def test_the_number_of_frames_is_limited(suffix, tmp_path):
    path = tmp_path / f"gait.{suffix}"
    write_gait(Gait(np.zeros((MOST_FRAMES + 1, 1)), ("a",), 25.0, 7, 1.5), path, suffix)
    with pytest.raises(GaitsimError, match=r"(?s)10,00[12] .* at most 10,000 frames"):
        read_gait(path)


@pytest.mark.parametrize(
    ("name", "kind", "shape"),
    [
        ("joint_angles", "<f8", (10**9, 3)),
        ("joint_angles", "<f8", (10**15, 3)),
        ("joint_angles", "<f8", (10**12, 0)),
        ("joint_names", "<U0", (10**12,)),
    ],
)
def test_arrays_that_claim_a_huge_size_are_rejected(name, kind, shape, tmp_path):
    header = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}}}\n".encode()
    valid = io.BytesIO()
    np.save(valid, ANGLES)
    path = tmp_path / "gait.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("bestGait.npy", valid.getvalue())
        archive.writestr(f"{name}.npy", b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header)
    with pytest.raises(GaitsimError, match=r"gait\.npz"):
        read_gait(path)


@pytest.mark.parametrize("version", ["4", "5"])
def test_other_variables_of_matlab_are_skipped(version):
    names = ("bestGait", "jointNames")
    more = {} if version == "4" else {"made": {"by": "me"}, "roots": ANGLES * 1j}
    found = read_matlab(matlab(version, first=ANGLES, **more), names, 10**6)
    assert found["bestGait"].tolist() == ANGLES.tolist()
    assert found["jointNames"].tolist() == [*NAMES]
    if version == "5":
        with pytest.raises(ValueError, match="roots is neither"):
            read_matlab(matlab(version, **more), ("roots",), 10**6)


@pytest.mark.parametrize("name", ["gait.csv", "gait.mat", "imitator.npz"])
def test_endless_files_are_rejected_at_once(name, tmp_path):
    read = load_imitator if name.startswith("imitator") else read_gait
    path = tmp_path / name
    os.mkfifo(path)
    with pytest.raises(GaitsimError, match="not a regular file"):
        read(path)
    path.unlink()
    path.symlink_to("/dev/zero")
    with pytest.raises(GaitsimError, match="not a regular file"):
        read(path)
    path.unlink()
    with path.open("wb") as file:
        file.truncate(10**11)
    with pytest.raises(GaitsimError, match="too large"):
        read(path)
