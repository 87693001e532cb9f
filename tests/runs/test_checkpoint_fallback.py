from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from gaitsim.errors import CheckpointError
from gaitsim.runs.files.checkpoint import read_checkpoint, read_with_fallback, write_checkpoint
from gaitsim.runs.files.safe_pickle import VERSION, SchemaVersionError


@pytest.fixture
def pair(tmp_path, checkpoint):
    """A checkpoint of generation 8 and the previous one, of generation 7."""
    path, previous = tmp_path / "population.pickle", tmp_path / "population.previous.pickle"
    write_checkpoint(path, checkpoint(), previous)
    assert not previous.exists()
    write_checkpoint(path, checkpoint(generation=8), previous)
    return path, previous


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def newer(path: Path) -> None:
    """Give an intact file the next schema version."""
    data = bytearray(path.read_bytes())
    data[8:12] = (VERSION + 1).to_bytes(4, "little")
    data[20:52] = sha256(data[:20] + data[52:]).digest()
    path.write_bytes(data)


def test_a_damaged_checkpoint_falls_back_and_is_kept(pair, checkpoint):
    path, previous = pair
    for number in (1, 2):
        damaged = path.read_bytes()[:-number] if path.exists() else b"damaged again"
        path.write_bytes(damaged)
        read, warning = read_with_fallback(path, previous)
        assert read.generation == 7
        assert "cannot read population.pickle" in warning
        assert f"kept as population.damaged-{number}.pickle" in warning
        assert "population.previous.pickle of generation 7 is used instead" in warning
        assert path.with_name(f"population.damaged-{number}.pickle").read_bytes() == damaged
        assert not path.exists()
    # The next write does not replace the only intact checkpoint.
    write_checkpoint(path, checkpoint(generation=9), previous)
    assert read_checkpoint(path).generation == 9
    assert read_checkpoint(previous).generation == 7
    assert len(names_in(path.parent)) == 4


def test_a_folder_in_place_of_the_checkpoint_is_renamed(pair, checkpoint):
    path, previous = pair
    path.unlink()
    path.mkdir()
    (path / "file").touch()
    assert read_with_fallback(path, previous)[0].generation == 7
    assert (path.with_name("population.damaged-1.pickle") / "file").exists()
    write_checkpoint(path, checkpoint(generation=9), previous)
    assert read_checkpoint(path).generation == 9


def test_a_newer_checkpoint_does_not_fall_back(pair):
    path, previous = pair
    newer(path)
    with pytest.raises(SchemaVersionError, match=r"population\.pickle"):
        read_with_fallback(path, previous)
    path.write_bytes(b"")
    newer(previous)
    with pytest.raises(SchemaVersionError, match=r"population\.previous\.pickle"):
        read_with_fallback(path, previous)
    assert names_in(path.parent) == {path.name, previous.name}


@pytest.mark.parametrize("missing", [True, False], ids=["missing", "damaged"])
def test_if_neither_checkpoint_can_be_read_the_error_names_both(pair, missing):
    for path in pair:
        path.unlink()
        if not missing:
            path.write_bytes(b"damaged")
    with pytest.raises(CheckpointError, match="neither") as refusal:
        read_with_fallback(*pair)
    for path in pair:
        assert path.name in refusal.value.what
        assert str(path) in refusal.value.where
        assert path.exists() is not missing


def test_a_folder_that_cannot_be_written_still_falls_back(pair, monkeypatch):
    path, previous = pair
    path.write_bytes(b"damaged")

    def forbidden(*names):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(Path, "replace", forbidden)
    read, warning = read_with_fallback(path, previous)
    assert read.generation == 7
    assert "Read-only file system" in warning
    assert names_in(path.parent) == {path.name, previous.name}


def test_too_little_memory_for_the_arrays_is_an_error(pair, monkeypatch):
    def exhausted(*args, **options):
        raise MemoryError

    monkeypatch.setattr(np, "frombuffer", exhausted)
    with pytest.raises(CheckpointError, match="more memory"):
        read_checkpoint(pair[0])
