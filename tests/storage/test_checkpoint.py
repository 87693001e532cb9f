import dataclasses
import math
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from gaitsim.errors import CheckpointError
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.checkpoint import (
    Champion,
    Checkpoint,
    Stage,
    Start,
    pack,
    read_champion,
    read_checkpoint,
    read_start,
    read_with_fallback,
    write_champion,
    write_checkpoint,
)
from gaitsim.storage.files.safe_pickle import VERSION, SchemaVersionError

INF = math.inf


def content(record) -> dict:
    """The content of the file of a record, as builtins."""
    return safe_pickle.loads(pack(record), Path("a.pickle"))


def same(one, other) -> None:
    for field in dataclasses.fields(one):
        assert_same(getattr(one, field.name), getattr(other, field.name))


def assert_same(one, other) -> None:
    if isinstance(one, dict):
        assert list(one) == list(other)
        for key in one:
            assert_same(one[key], other[key])
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert one.tobytes() == other.tobytes()
    else:
        assert type(one) is type(other)
        assert one == other


reals = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1, max_size=20)
versions = st.dictionaries(names, names, max_size=3)


shapes = array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3)
states = arrays(st.sampled_from([np.float64, np.int64, np.uint8, np.bool_]), shapes)


@st.composite
def checkpoints(draw):
    individuals, genes = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    real = arrays(np.float64, (individuals, genes), elements=reals)
    bits = arrays(np.uint8, (individuals, genes), elements=st.integers(0, 1))
    scores = draw(arrays(np.float64, individuals, elements=reals | st.just(-INF)))
    failed = np.flatnonzero(scores == -INF)
    terms = {}
    for name in draw(st.lists(names, unique=True, max_size=3)):
        terms[name] = draw(arrays(np.float64, individuals, elements=reals))
        terms[name][failed] = draw(st.floats())
    *ends, generation = sorted(draw(st.sets(st.integers(1, 10**8), min_size=1, max_size=4)))
    stages = tuple(Stage(end, draw(st.text()), draw(versions)) for end in ends)
    return Checkpoint(
        experiment=draw(st.text()),
        versions=draw(versions),
        generation=generation,
        evaluations=individuals * generation,
        genomes=draw(real | bits),
        scores=scores,
        terms=terms,
        reasons={str(index): draw(st.text()) for index in failed},
        stagnation=draw(st.integers(0, generation - 1)),
        best_score=max(draw(reals | st.just(-INF)), float(scores.max())),
        threshold=draw(st.none() | reals),
        stages=stages,
        values={"yaw": scores.copy()},
        state=draw(st.dictionaries(names, states, max_size=3)),
    )


champions = st.builds(
    Champion,
    experiment=st.text(),
    versions=versions,
    generation=st.integers(1, 10**8),
    genome=arrays(np.float64, 3, elements=reals) | arrays(np.uint8, 3),
    score=reals,
    terms=st.dictionaries(names, reals, max_size=3),
)


@settings(max_examples=50)
@given(checkpoints())
def test_a_checkpoint_is_read_as_it_was_written(tmp_path_factory, written):
    path = tmp_path_factory.getbasetemp() / "population.pickle"
    write_checkpoint(path, written)
    same(written, read_checkpoint(path))


@settings(max_examples=50)
@given(champions)
def test_a_champion_is_read_as_it_was_written(tmp_path_factory, written):
    path = tmp_path_factory.getbasetemp() / "champion.pickle"
    write_champion(path, written)
    same(written, read_champion(path))


def test_equal_checkpoints_have_equal_bytes(checkpoint):
    genomes = np.random.default_rng(1).normal(size=(4, 3))
    other = checkpoint(
        genomes=np.asfortranarray(genomes).astype(">f8"),
        best_score=np.float64(2.5),
        generation=np.int64(7),
        stages=[],
    )
    assert pack(other) == pack(checkpoint(genomes=genomes))


# Contents that are refused

UNWRITABLE = {
    "float32 genomes": {"genomes": np.zeros((4, 3), np.float32)},
    "genomes of one dimension": {"genomes": np.zeros(4)},
    "no genomes": {"genomes": np.zeros((0, 3)), "scores": np.zeros(0), "terms": {}, "reasons": {}},
    "an infinite genome": {"genomes": np.full((4, 3), INF)},
    "more scores than genomes": {"scores": np.zeros(5), "reasons": {}},
    "a score that is not a number": {"scores": np.array([0, -INF, 0, np.nan])},
    "an infinite score": {"scores": np.array([0, -INF, 0, INF])},
    "a term that is not a number": {"terms": {"speed": np.array([np.nan, 0, 0, 0])}},
    "an infinite term": {"terms": {"speed": np.array([0, 0, -INF, 0])}},
    "more terms than genomes": {"terms": {"speed": np.zeros(5)}},
    "a term without a name": {"terms": {"": np.zeros(4)}},
    "a term whose name moves the cursor": {"terms": {"\x1b[2J": np.zeros(4)}},
    "a name of any length": {"terms": {"x" * 201: np.zeros(4)}},
    "a reason without a failure": {"reasons": {"0": "why"}},
    "a reason for nobody": {"reasons": {"4": "why"}},
    "a reason for an index in another form": {"reasons": {"01": "why"}},
    "a reason that is not a string": {"reasons": {"1": None}},
    "a negative generation": {"generation": -1},
    "a fractional generation": {"generation": 1.0},
    "a generation that is true": {"generation": True},
    "evaluations that are true": {"evaluations": False},
    "a negative stagnation": {"stagnation": -1},
    "a best score that is not a number": {"best_score": math.nan},
    "a threshold that is true": {"threshold": True},
    "an infinite threshold": {"threshold": -INF},
    "an experiment of bytes": {"experiment": b"x"},
    "versions that are a list": {"versions": ["0.1.0"]},
    "stages out of order": {"stages": (Stage(2, "", {}), Stage(1, "", {}))},
    "a stage that ends with the checkpoint": {"stages": (Stage(7, "", {}),)},
    "a stage with versions that are not strings": {"stages": (Stage(1, "", {"numpy": 2}),)},
    "a stage that is a string": {"stages": ("",)},
}


@pytest.mark.parametrize("changes", UNWRITABLE.values(), ids=UNWRITABLE.keys())
def test_an_unreadable_checkpoint_is_not_written(changes, tmp_path, checkpoint):
    path = tmp_path / "a"
    with pytest.raises(ValueError, match=r"cannot write this|a checkpoint cannot contain"):
        write_checkpoint(path, checkpoint(**changes))
    assert not path.exists()


@pytest.mark.parametrize(
    "changes",
    [
        {"score": -INF},
        {"score": math.nan},
        {"score": 1},
        {"terms": {"speed": math.inf}},
        {"terms": {"speed": True}},
        {"genome": np.array([np.nan])},
        {"genome": np.zeros((1, 1))},
        {"genome": np.zeros(0)},
        {"generation": -1},
    ],
    ids=repr,
)
def test_an_unreadable_champion_is_not_written(changes, tmp_path, champion):
    with pytest.raises(ValueError, match="cannot write this champion"):
        write_champion(tmp_path / "a", champion(**changes))


def array(dtype="<f8", shape=(4, 3), data=bytes(96), **more):
    return {"dtype": dtype, "shape": list(shape), "bytes": data, **more}


GENOMES = {
    "objects": array("|O"),
    "big-endian": array(">f8"),
    "a structure": array("<f8,<f8"),
    "a dtype that is a list": array(["<f8"]),
    "a long shape": array(shape=(4, 4)),
    "a negative shape": array(shape=(-4, -3)),
    "a shape of 0": array(shape=(0, 3), data=b""),
    "a shape that overflows 64 bits": array(shape=(2**40, 2**40)),
    "a shape that overflows to the right length": array(shape=(2**60 + 4, 3)),
    "a shape of floats": array(shape=(4.0, 3)),
    "a shape of three": array(shape=(4, 3, 1)),
    "a shape of none": array(shape=(), data=bytes(8)),
    "a shape that is not a list": array() | {"shape": 12},
    "bytes that are text": array(data="x" * 96),
    "one more key": array(more=1),
    "not a number": array(data=b"\xff" * 96),
    "nothing": None,
}


def refused(path: Path, read=read_checkpoint) -> CheckpointError:
    with pytest.raises(CheckpointError) as refusal:
        read(path)
    assert path.name in refusal.value.what
    assert str(path) in refusal.value.where
    assert refusal.value.remedy
    return refusal.value


@pytest.mark.parametrize("genomes", GENOMES.values(), ids=GENOMES.keys())
def test_invalid_arrays_are_rejected(genomes, tmp_path, checkpoint):
    path = tmp_path / "population.pickle"
    path.write_bytes(safe_pickle.dumps(content(checkpoint()) | {"genomes": genomes}))
    assert "population.genomes" in refused(path).what


@pytest.mark.parametrize("kind", ["population", "champion"])
def test_every_key_is_required_and_no_other_allowed(kind, tmp_path, checkpoint, champion):
    record = checkpoint() if kind == "population" else champion()
    path = tmp_path / "a.pickle"
    right = content(record)
    read = read_checkpoint if kind == "population" else read_champion
    for key in right:
        without = {other: value for other, value in right.items() if other != key}
        if key == "finished":  # checkpoints of version 0.1.0 do not have it
            path.write_bytes(safe_pickle.dumps(without))
            assert read_checkpoint(path).finished == ""
            without = {}
        for wrong in (without, right | {key: -1}, right | {key: [None]}, right | {"more": 1}):
            path.write_bytes(safe_pickle.dumps(wrong))
            refused(path, read)
    path.write_bytes(safe_pickle.dumps(right))
    assert read(path).versions == record.versions


@pytest.mark.parametrize(
    "stages",
    [
        None,
        {},
        [1],
        [{"generation": 1}],
        [{"generation": 1, "experiment": ""}],
        [{"generation": True, "experiment": "", "versions": {}}],
    ],
    ids=repr,
)
def test_stages_are_checked(stages, tmp_path, checkpoint):
    path = tmp_path / "population.pickle"
    path.write_bytes(safe_pickle.dumps(content(checkpoint()) | {"stages": stages}))
    assert "population.stages" in refused(path).what


def test_a_start_is_read_as_written_and_from_a_champion(tmp_path, champion):
    one = champion()
    several = Start("name = 'a'", np.array([[0.5, 1.0], [2.0, -3.0]]))
    for record, genomes, generation in (
        (several, several.genomes, 0),
        (one, one.genome[None], one.generation),
    ):
        path = tmp_path / "start.pickle"
        path.write_bytes(pack(record))
        found = read_start(path)
        assert np.array_equal(found.genomes, genomes)
        assert found.generation == generation
    path.write_bytes(pack(several))
    assert "'champion'" in refused(path, read_champion).allowed


def test_a_champion_is_not_read_as_a_population(tmp_path, checkpoint, champion):
    write_champion(tmp_path / "a", champion())
    assert "'population'" in refused(tmp_path / "a").allowed
    write_checkpoint(tmp_path / "a", checkpoint())
    assert "'champion'" in refused(tmp_path / "a", read_champion).allowed


def test_hostile_names_do_not_reach_the_terminal(tmp_path, checkpoint):
    path = tmp_path / "population.pickle"
    wrong = content(checkpoint()) | {"terms": {"\x1b[2J": 1}, "\x1b[3J": 1}
    path.write_bytes(safe_pickle.dumps(wrong))
    assert "\x1b" not in str(refused(path))
    del wrong["\x1b[3J"]
    path.write_bytes(safe_pickle.dumps(wrong))
    assert "\x1b" not in str(refused(path))


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
