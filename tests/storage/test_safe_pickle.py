import io
import os
import pickle
import re
import struct
import subprocess
import sys
import tracemalloc
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from run_helpers import seal

from gaitsim.errors import CheckpointError, RunError
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.safe_pickle import (
    VERSION,
    RejectedPickleError,
    SchemaVersionError,
    dumps,
    load,
    loads,
)

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


PROTO = b"\x80\x05"
MARKER = "executed"
NAME = b"X\x08\0\0\0executed"


def value_of(opcodes: bytes) -> bytes:
    """A pickle of {'a': what the opcodes build}."""
    return PROTO + b"}\x8c\x01a" + opcodes + b"s."


EXECUTING = {
    "GLOBAL and REDUCE": PROTO + b"cos\nmkdir\n(" + NAME + b"tR.",
    "STACK_GLOBAL and REDUCE": PROTO + b"\x8c\x02os\x8c\x05mkdir\x93" + NAME + b"\x85R.",
    "INST": PROTO + b"(" + NAME + b"ios\nmkdir\n.",
    "OBJ": PROTO + b"(cos\nmkdir\n" + NAME + b"o.",
    "inside an honest dict": value_of(b"cos\nmkdir\n(" + NAME + b"tR"),
    "before an honest dict": PROTO + b"cos\nmkdir\n(" + NAME + b"tR0}.",
    "as a key": PROTO + b"}cos\nmkdir\n(" + NAME + b"tRNs.",
}
HUGE = struct.pack("<Q", 2**40)
REFUSED = EXECUTING | {
    "GLOBAL alone": value_of(b"cos\nsystem\n"),
    "BUILD": value_of(b"}}b"),
    "NEWOBJ": value_of(b"cpathlib\nPath\n)\x81"),
    "NEWOBJ_EX": value_of(b"cpathlib\nPath\n)}\x92"),
    "EXT1": value_of(b"\x82\x01"),
    "EXT4": value_of(b"\x84\x01\x01\x01\x01"),
    "PERSID": value_of(b"Pname\n"),
    "BINPERSID": value_of(b"NQ"),
    "BYTEARRAY8": value_of(b"\x96" + struct.pack("<Q", 1) + b"x"),
    "NEXT_BUFFER": value_of(b"\x97"),
    "BINBYTES, huge": value_of(b"B\xff\xff\xff\x7f"),
    "BINBYTES8, huge": value_of(b"\x8e" + HUGE + b"x"),
    "BINBYTES8, beyond any memory": value_of(b"\x8e" + b"\xff" * 8),
    "BINUNICODE, huge": value_of(b"X\xff\xff\xff\xff"),
    "BINUNICODE8, huge": value_of(b"\x8d" + HUGE + b"x"),
    "BINUNICODE8, beyond any memory": value_of(b"\x8d" + b"\xff" * 8),
    "FRAME, huge": PROTO + b"\x95" + HUGE + b"}.",
    "FRAME, one too long": PROTO + b"\x95" + struct.pack("<Q", 3) + b"}.",
    "LONG1 of 255 bytes": value_of(b"\x8a\xff" + b"\x01" * 255),
    "LONG1 of 9 bytes": value_of(b"\x8a\x09" + b"\x01" * 9),
    "LONG4": value_of(b"\x8b\x01\0\0\0\x01"),
    "LONG4, huge": value_of(b"\x8b\xff\xff\xff\x7f"),
    "INT": value_of(b"I" + b"9" * 5000 + b"\n"),
    "LONG": value_of(b"L" + b"9" * 5000 + b"L\n"),
    "FLOAT": value_of(b"F1.5\n"),
    "STRING with a bad escape": value_of(b"S'\\q'\n"),
    "UNICODE": value_of(b"Vtext\n"),
    "PUT": value_of(b"]p2147483647\n"),
    "BINPUT": value_of(b"]q\0"),
    "LONG_BINPUT, huge": value_of(b"]r\xff\xff\xff\x7f"),
    "GET": value_of(b"]\x94g0\n"),
    "BINGET": value_of(b"h\0"),
    "LONG_BINGET": value_of(b"j\xff\xff\xff\x7f"),
    "MEMOIZE": value_of(b"]\x94"),
    "a memo bomb": value_of(
        b"]\x94" + b"".join(b"](" + b"h%c" % n * 10 + b"e\x94" for n in range(99))
    ),
    "a bomb of DUP": value_of(b"]" + b"]22aa2" * 100),
    "a list in itself": value_of(b"]\x94h\0a"),
    "POP": value_of(b"N0N"),
    "POP_MARK": value_of(b"(N1N"),
    "a tuple": value_of(b"(t"),
    "an empty tuple": value_of(b")"),
    "a set": value_of(b"\x8f"),
    "deep lists": value_of(b"]" * 5000 + b"a" * 4999),
    "deep dicts": value_of(b"}\x8c\x01a" * 5000 + b"N" + b"s" * 5000),
    "one container too deep": value_of(b"]" * 16 + b"a" * 15),
    "a whole number as key": PROTO + b"}K\x01Ns.",
    "bytes as key": PROTO + b"}C\x01aNs.",
    "None as key": PROTO + b"}NNs.",
    "a list as key": PROTO + b"}]Ns.",
    "a bad key among good ones": PROTO + b"}(\x8c\x01aNK\x01Nu.",
    "a key without value": PROTO + b"}(\x8c\x01aN\x8c\x01bu.",
    "text that is half a surrogate pair": value_of(b"\x8c\x03\xed\xa0\x80"),
    "text that is not UTF-8": value_of(b"\x8c\x01\xff"),
    "a list": PROTO + b"].",
    "no value": PROTO + b".",
    "two values": PROTO + b"}}.",
    "a mark left": PROTO + b"(}.",
    "a mark missing": PROTO + b"]Ne.",
    "a mark passed": PROTO + b"}\x8c\x01a](Nae.",
    "items for a dict in a list": PROTO + b"]\x8c\x01aNs.",
    "items for nothing": PROTO + b"\x8c\x01aNs.",
    "nothing": b"",
    "no STOP": PROTO + b"}",
    "an unknown opcode": value_of(b"\xff"),
    "a trailing byte": PROTO + b"}.\0",
    "two pickles": (PROTO + b"}.") * 2,
    "no PROTO": b"}.",
    "protocol 4": b"\x80\x04}.",
    "PROTO again": PROTO + b"\x80\x05}.",
}


@pytest.mark.parametrize("payload", EXECUTING.values(), ids=EXECUTING.keys())
def test_the_attacks_work_on_a_plain_unpickler(payload, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pickle.loads(payload)
    assert Path(MARKER).is_dir()


@pytest.mark.parametrize("payload", REFUSED.values(), ids=REFUSED.keys())
def test_hostile_files_are_rejected_before_any_opcode_runs(payload, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    FILE.write_bytes(seal(payload))
    monkeypatch.setattr(safe_pickle, "_Reader", None)  # the scan alone must reject it
    tracemalloc.start()
    try:
        with pytest.raises(CheckpointError) as refusal:
            load(FILE)
        assert tracemalloc.get_traced_memory()[1] < 4_000_000
    finally:
        tracemalloc.stop()
    assert FILE.name in refusal.value.what
    assert "NoneType" not in refusal.value.what
    assert refusal.value.remedy
    assert not Path(MARKER).exists()


@pytest.mark.parametrize(
    "payload", [b"cos\nsystem\n.", b"\x8c\x02os\x8c\x06system\x93.", b"\x82\1."]
)
def test_the_reader_imports_nothing_even_without_the_scan(payload):
    with pytest.raises((RejectedPickleError, ValueError)):
        safe_pickle._Reader(io.BytesIO(payload)).load()


def test_too_many_opcodes_and_too_much_text_are_rejected(monkeypatch):
    many, long = dumps({"a": [None] * 200}), dumps({"a": ["é" * 60, "é" * 60]})
    monkeypatch.setattr(safe_pickle, "MAX_OPCODES", 100)
    monkeypatch.setattr(safe_pickle, "MAX_TEXT", 100)
    with pytest.raises(CheckpointError, match="more than 100 opcodes"):
        loads(many, FILE)
    with pytest.raises(CheckpointError, match="more than 100 characters"):
        loads(long, FILE)


@settings(max_examples=500)
@given(st.binary(max_size=60))
def test_any_payload_is_read_or_rejected(payload):
    with suppress(CheckpointError):
        assert type(loads(seal(PROTO + payload + b"."), FILE)) is dict
