"""Untrusted gait files are read, or rejected with one message, whatever they contain."""

import io
import os
import random
import struct
import zipfile
import zlib
from itertools import chain, islice
from types import SimpleNamespace

import numpy as np
import pytest
from mutations import mutations
from scipy.io import savemat

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import MOST_FRAMES, Gait, read_gait, write_gait
from gaitsim.gait.matlab import read_matlab
from gaitsim.imitation import load_imitator
from gaitsim.imitation.imitator import Imitation, Imitator, save_imitator
from gaitsim.network import Network

NAMES = ("L1 coxa", "naïve, joint", "c")
ANGLES = np.array([[0.0, 0.1, -0.2], [0.05, 0.125, -0.25], [0.1, 1 / 3, 0], [0, 0, 0]])
WORDS = (0, 1, 2, 3, 5, 6, 7, 9, 14, 15, 16, 18, 99, 8192, 2**31 - 1, 2**31, 2**32 - 1)


def matlab(version, **more):
    file = io.BytesIO()
    # Version 4 has no cells, but a matrix of letters.
    names = np.array(NAMES) if version == "4" else np.array(NAMES, dtype=object)
    values = {"bestGait": ANGLES, "frameRate": 25.0, "jointNames": names, "units": "rad"}
    savemat(file, values | more, format=version)
    return file.getvalue()


def packed(data):
    """The same file of MATLAB with each variable packed, as MATLAB writes it."""
    whole, at = data[:128], 128
    while at + 8 <= len(data):
        size = struct.unpack_from("<I", data, at + 4)[0]
        part = zlib.compress(data[at : at + 8 + size])
        whole += struct.pack("<II", 15, len(part)) + part
        at += 8 + size
    return whole + data[at:]


def packed_mutant(data, chance):
    """A file of MATLAB with mutations beneath the packing, which a checksum guards."""
    return packed(words(data, chance))


def words(data, chance):
    """Change some of the 32-bit numbers that encode types and sizes."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 5))):
        at = 4 * chance.randrange(len(data) // 4)
        changed[at : at + 4] = struct.pack("<I", chance.choice(WORDS))
    return bytes(changed)


def arrays_mutant(data, chance):
    """A `.npz` file with mutations in one array, beneath the packing and its checksums."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = chance.choice([*members])
    members[name] = next(mutations(members[name], 1, chance.getrandbits(32)))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file.getvalue()


def exported(format, tmp_path):
    path = tmp_path / f"valid.{format}"
    write_gait(Gait(ANGLES, NAMES, 25.0, 7, 1.5), path, format)
    return path.read_bytes()


def imitator(tmp_path):
    network = Network(
        (np.ones((4, 3)), np.ones((3, 4))), (np.ones(4), np.ones(3)), "leaky-relu", "linear"
    )
    gait = Gait(ANGLES, NAMES, 25.0, 7, 1.5)
    path = tmp_path / "valid.npz"
    save_imitator(Imitation(gait, ANGLES, Imitator(network, np.zeros(3), 1.0), 3), path)
    return path.read_bytes()


CASES = {
    "matlab 5": SimpleNamespace(
        make=lambda _: matlab("5"), change=words, suffix="mat", read=read_gait
    ),
    "matlab 5 packed": SimpleNamespace(
        make=lambda _: matlab("5"), change=packed_mutant, suffix="mat", read=read_gait
    ),
    "matlab 4": SimpleNamespace(
        make=lambda _: matlab("4"), change=words, suffix="mat", read=read_gait
    ),
    "npz": SimpleNamespace(
        make=lambda folder: exported("npz", folder),
        change=arrays_mutant,
        suffix="npz",
        read=read_gait,
    ),
    "csv": SimpleNamespace(
        make=lambda folder: exported("csv", folder), change=None, suffix="csv", read=read_gait
    ),
    "imitator": SimpleNamespace(
        make=imitator, change=arrays_mutant, suffix="npz", read=load_imitator
    ),
}


def check(case, count, tmp_path):
    """Check mutations: half of single bytes, half of elements of the format."""
    valid, chance = case.make(tmp_path), random.Random(1)
    path = tmp_path / f"mutant.{case.suffix}"
    path.write_bytes(valid)
    case.read(path)
    blind = mutations(valid, count)
    if case.change is not None:
        aimed = (case.change(valid, chance) for _ in range(count // 2))
        blind = chain(islice(blind, count // 2), aimed)
    refusals = []
    for data in blind:
        path.write_bytes(data)
        try:
            case.read(path)
        except GaitsimError as error:
            refusals.append(error)
    assert len(refusals) > count // 4
    assert all(str(path) in error.what and len(str(error)) < 1000 for error in refusals)


@pytest.mark.parametrize("name", CASES)
def test_mutants_are_read_or_rejected(name, tmp_path):
    check(CASES[name], 30, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_many_mutants_are_read_or_rejected(name, tmp_path):
    check(CASES[name], 500, tmp_path)


# One changed byte in each of these crashes the process in SciPy's reader (1.17): the type of the
# numbers is 14, 15, 99 or 8192. Two zeros named bestGait, without the header's text.
CRASHERS = [
    "0e000000480000000600000008000000060000000000000005000000080000000200000001000000"
    f"0100000008000000626573744761697{tail}000000000000000000000000000000"
    for tail in ("40e0000001000000000", "40f0000001000000000", "4630000001000000000",
                 "4002000001000000000")
]  # fmt: skip


@pytest.mark.parametrize("crasher", CRASHERS)
def test_files_that_crashed_scipy_are_rejected(crasher, tmp_path):
    path = tmp_path / "gait.mat"
    path.write_bytes(b"MATLAB".ljust(124) + b"\0\1IM" + bytes.fromhex(crasher)[:80])
    with pytest.raises(GaitsimError, match="bestGait is neither a real matrix nor text"):
        read_gait(path)


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
