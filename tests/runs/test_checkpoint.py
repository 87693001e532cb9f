import dataclasses
import math
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from gaitsim.runs.files import safe_pickle
from gaitsim.runs.files.checkpoint import (
    Champion,
    Checkpoint,
    Stage,
    pack,
    read_champion,
    read_checkpoint,
    write_champion,
    write_checkpoint,
)

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


def test_arrays_are_read_writable_and_in_native_byte_order(tmp_path, checkpoint):
    write_checkpoint(tmp_path / "a", checkpoint())
    read = read_checkpoint(tmp_path / "a")
    for array in (read.genomes, read.scores, *read.terms.values()):
        assert array.dtype.isnative
        assert array.flags.writeable
        assert array.flags.c_contiguous
        assert array.flags.owndata or array.base.flags.owndata


def test_equal_checkpoints_have_equal_bytes(checkpoint):
    genomes = np.random.default_rng(1).normal(size=(4, 3))
    other = checkpoint(
        genomes=np.asfortranarray(genomes).astype(">f8"),
        best_score=np.float64(2.5),
        generation=np.int64(7),
        stages=[],
    )
    assert pack(other) == pack(checkpoint(genomes=genomes))


def test_a_checkpoint_opens_in_plain_python_and_numpy(checkpoint, champion):
    opened = content(checkpoint())
    genomes = opened["genomes"]
    array = np.frombuffer(genomes["bytes"], genomes["dtype"]).reshape(genomes["shape"])
    assert np.array_equal(array, checkpoint().genomes)
    assert opened["kind"] == "population"
    assert opened["stages"] == []
    assert content(champion())["kind"] == "champion"


def test_a_large_population_is_read(tmp_path, checkpoint):
    genomes = np.random.default_rng(0).normal(size=(1000, 5000))
    scores = np.full(1000, -INF)
    reasons = {str(index): "fell over" for index in range(1000)}
    large = checkpoint(
        genomes=genomes, scores=scores, terms={"speed": scores}, reasons=reasons, values={}
    )
    write_checkpoint(tmp_path / "a", large)
    same(large, read_checkpoint(tmp_path / "a"))
