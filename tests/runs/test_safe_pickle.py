import os
import pickle
import re
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from run_helpers import seal

from gaitsim.errors import CheckpointError, RunError
from gaitsim.runs.files import safe_pickle
from gaitsim.runs.files.safe_pickle import VERSION, SchemaVersionError, dumps, load, loads

FILE = Path("population.pickle")


HONEST = dumps({"name": "spider", "count": 3, "list": [1.5, None, True], "bytes": b"\0\1"})


def builtins_deep(keys: st.SearchStrategy[str]) -> st.SearchStrategy[object]:
    numbers = st.integers(-(2**63), 2**63 - 1) | st.floats() | st.booleans()
    leaves = st.none() | numbers | st.text() | st.binary(max_size=300)
    return st.recursive(leaves, lambda x: st.lists(x) | st.dictionaries(keys, x), max_leaves=30)


contents = st.dictionaries(st.text(), builtins_deep(st.text()))


@settings(max_examples=25)
@given(contents)
def test_written_content_is_read(content):
    data = dumps(content)
    # repr tells 1 from True and −0.0 from 0.0, and NaN equals itself in it.
    assert repr(loads(data, FILE)) == repr(content)
    assert data == seal(data[52:])


def test_any_python_opens_it_past_the_header():
    content = {"name": "spider", "genes": [1.5, -2.5], "array": {"bytes": b"\0\1"}}
    assert safe_pickle.HEADER == 52
    program = "import pickle, sys; print(pickle.loads(sys.stdin.buffer.read()[52:]))"
    opened = subprocess.run(
        [sys.executable, "-I", "-S", "-c", program],
        input=dumps(content),
        capture_output=True,
        check=True,
    )
    assert opened.stdout.decode().strip() == str(content)


@pytest.mark.parametrize(
    "value",
    [
        (1,),
        {1},
        bytearray(b"x"),
        2**63,
        -(2**63) - 1,
        10**1000,
        np.float64(1.0),
        np.zeros(3),
        1j,
        object(),
        print,
        lambda: None,
        {1: 2},
        {None: 2},
        "\ud800",
        FILE,
    ],
    ids=lambda value: re.sub(" at 0x.*", "", repr(value)),
)
def test_only_builtins_are_written(value):
    with pytest.raises(ValueError, match="a checkpoint cannot contain this"):
        dumps({"a": value})


def test_cycles_and_depth_are_not_written():
    cycle: list[object] = []
    cycle.append(cycle)
    deep: list[object] = []
    for _ in range(100_000):
        deep = [deep]
    for value in (cycle, deep):
        with pytest.raises(ValueError, match="a checkpoint cannot contain this"):
            dumps({"a": value})


def test_a_file_too_large_to_read_is_not_written(monkeypatch):
    monkeypatch.setattr(safe_pickle, "MAX_BYTES", 100)
    with pytest.raises(ValueError, match="at most 100 bytes"):
        dumps({"a": b"x" * 100})


def test_content_beyond_the_limits_is_not_written(monkeypatch):
    monkeypatch.setattr(safe_pickle, "MAX_OPCODES", 200)
    for count in (20, 60, 150):
        assert loads(dumps({"a": [None] * count}), FILE) == {"a": [None] * count}
    with pytest.raises(ValueError, match="more than 200 opcodes"):
        dumps({"a": [None] * 200})
    monkeypatch.setattr(safe_pickle, "MAX_TEXT", 5000)
    with pytest.raises(ValueError, match="more than 5,000 characters"):
        dumps({"a": "é" * 5001})


def test_files_truncated_anywhere_are_rejected():
    for length in range(len(HONEST)):
        with pytest.raises(CheckpointError, match=r"population\.pickle"):
            loads(HONEST[:length], FILE)


@pytest.mark.parametrize("change", [0x01, 0x80, 0xFF])
def test_files_with_any_byte_changed_are_damaged_not_newer(change):
    for index in range(len(HONEST)):
        changed = bytearray(HONEST)
        changed[index] ^= change
        with pytest.raises(CheckpointError) as refusal:
            loads(bytes(changed), FILE)
        assert not isinstance(refusal.value, SchemaVersionError)


@pytest.mark.parametrize("more", [-1, 1, 2**63])
def test_a_wrong_length_is_rejected(more):
    with pytest.raises(CheckpointError, match="bytes instead of"):
        loads(seal(HONEST[52:], more=more), FILE)


@pytest.mark.parametrize(
    "data",
    [b"", b"\n", pickle.dumps({"a": 1}), b"\x89PNG\r\n\x1a\n" + bytes(60), b"a = 1\n" * 20],
    ids=["empty", "a line", "a plain pickle", "a picture", "a TOML file"],
)
def test_other_files_are_rejected(data, tmp_path):
    path = tmp_path / "other"
    path.write_bytes(data)
    with pytest.raises(CheckpointError, match=r"it is (empty|a different kind of file)"):
        load(path)


@pytest.mark.parametrize("version", [VERSION + 1, 2**32 - 1])
def test_a_newer_schema_asks_for_an_update(version):
    with pytest.raises(SchemaVersionError) as refusal:
        loads(seal(b"anything at all", version), FILE)
    assert f"in format {version}" in refusal.value.what
    assert "update gaitsim" in refusal.value.remedy


@pytest.mark.parametrize(
    ("content", "writer"),
    [({"versions": {"gaitsim": "0.7"}}, "gaitsim 0.7"), ({"versions": 3}, "gaitsim ?")],
)
def test_an_older_schema_names_the_gaitsim_that_wrote_it(content, writer):
    with pytest.raises(SchemaVersionError) as refusal:
        loads(seal(dumps(content)[52:], VERSION - 1), FILE)
    assert writer in refusal.value.what


def test_folders_and_devices_are_rejected(tmp_path):
    with pytest.raises(CheckpointError, match="Is a directory"):
        load(tmp_path)
    with pytest.raises(CheckpointError, match="file not found"):
        load(tmp_path / "missing.pickle")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(CheckpointError, match="not a regular file"):
            load(tmp_path / "pipe")


def test_huge_files_are_rejected_unread(tmp_path):
    path = tmp_path / "huge.pickle"
    with path.open("wb") as file:
        file.write(HONEST)
        file.truncate(safe_pickle.MAX_BYTES + 1)
    tracemalloc.start()
    try:
        with pytest.raises(CheckpointError, match="1,073,741,825 bytes"):
            load(path)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "error", [MemoryError(), RecursionError(), KeyError("x"), AttributeError(), EOFError()]
)
def test_any_error_of_unpickling_is_a_checkpoint_error(error, monkeypatch):
    class Broken(pickle.Unpickler):
        def load(self):
            raise error

    monkeypatch.setattr(safe_pickle, "_Reader", Broken)
    with pytest.raises(CheckpointError, match=r"cannot read .* as a checkpoint"):
        loads(HONEST, FILE)


def test_a_file_without_read_permission_is_not_called_damaged(tmp_path, monkeypatch):
    path = tmp_path / "population.pickle"
    path.write_bytes(HONEST)

    def forbidden(*args, **options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", forbidden)
    with pytest.raises(RunError, match="permission denied") as refusal:
        load(path)
    assert not isinstance(refusal.value, CheckpointError)


def test_there_is_no_version_0():
    with pytest.raises(CheckpointError, match="no schema version 0"):
        loads(seal(HONEST[52:], 0), FILE)
