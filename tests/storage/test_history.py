import math
import os

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim.contracts import BitSpace, RealSpace
from gaitsim.errors import RunError
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation, SearchProgress
from gaitsim.storage.files.history import COLUMNS, read_history, read_records, record_type, row
from gaitsim.storage.files.records import AppendOnlyFile
from gaitsim.storage.files.tables import line, line_ends

INF = math.inf
scores = st.floats(-1e6, 1e6)


def generation(scores, terms=None, number=3):
    scores = np.array(scores, dtype=float)
    terms = {"reach": scores} if terms is None else terms
    return Generation(
        number=number,
        genomes=np.zeros((len(scores), 2)),
        evaluation=Evaluation(scores.copy(), {k: np.array(v) for k, v in terms.items()}, {}),
        progress=SearchProgress(70, 1.0, 0, None),
        diversity=0.25,
        seconds=0.125,
        is_champion=False,
        stop="",
    )


@given(st.lists(scores, min_size=1, max_size=9))
def test_a_row_has_the_statistics_of_numpy(scores):
    values = row(generation(scores))
    expected = {
        "generation": 3,
        "stage": 1,
        "evaluations": 70,
        "best": np.max(scores),
        "mean": np.mean(scores),
        "median": np.median(scores),
        "lower quartile": np.quantile(scores, 0.25),
        "upper quartile": np.quantile(scores, 0.75),
        "worst": np.min(scores),
        "std": np.std(scores),
        "diversity": 0.25,
        "seconds": 0.125,
        "reach": np.max(scores),
        "mean:reach": np.mean(scores),
    }
    assert list(values) == list(expected)
    assert list(values)[:12] == list(COLUMNS)
    assert values == pytest.approx(expected, rel=1e-12, abs=1e-9)


def test_failed_individuals_only_affect_the_worst_score():
    values = row(generation([1.0, -INF, 3.0], {"far": [1.0, math.nan, 3.0]}))
    assert values["worst"] == -INF
    assert (values["best"], values["mean"], values["median"]) == (3.0, 2.0, 2.0)
    assert (values["std"], values["mean:far"]) == (1.0, 2.0)
    assert (values["lower quartile"], values["upper quartile"]) == (1.5, 2.5)


def table(*generations):
    rows = [row(one) for one in generations]
    return "".join([line(rows[0]), *(line(row.values()) for row in rows)])


@settings(max_examples=50)
@given(st.lists(st.lists(scores | st.just(-INF), min_size=1, max_size=4), min_size=1, max_size=4))
def test_values_are_read_as_written_to_the_last_bit(tmp_path_factory, bests):
    path = tmp_path_factory.getbasetemp() / "history.csv"
    generations = [generation(scores, number=n) for n, scores in enumerate(bests, start=1)]
    path.write_text(table(*generations))
    read = read_history(path)
    for number, one in enumerate(generations):
        for name, value in row(one).items():
            assert repr(float(read[name][number])) == repr(float(value))


def test_an_incomplete_last_row_is_omitted(tmp_path):
    path = tmp_path / "history.csv"
    text = table(generation([1.0], number=1), generation([2.0], number=2))
    ends = np.cumsum([len(line) for line in text.splitlines(keepends=True)]).tolist()
    for cut in range(len(text)):
        path.write_text(text[:cut])
        whole = text[:cut].count("\n")
        assert line_ends(path, 9) == ends[:whole]
        assert len(read_history(path).get("best", [])) == max(whole - 1, 0)
    assert read_history(tmp_path / "missing.csv") == {}
    assert line_ends(tmp_path / "missing.csv", 9) == []


GOOD = table(generation([1.0], number=1), generation([2.0], number=2))
DAMAGED = {
    "another table": "a,b\n1,2\n",
    "no header": GOOD.split("\n", 1)[1],
    "another header": GOOD.replace("median", "middle"),
    "a word": GOOD.replace("0.125", "soon"),
    "a cell less": GOOD.replace("0.125,", "", 1),
    "a row missing": GOOD.replace("\n1,", "\n2,", 1),
    "an empty line": GOOD.replace("\n2,", "\n\n2,"),
    "a zero byte": GOOD.replace("70", "7\0"),
    "no text": GOOD.encode("utf-16"),
    "an open quote": GOOD.replace("median", '"median'),
    "a column more": GOOD.replace("\n", ",1\n").replace("reach,1", "reach,more"),
    "a term twice": GOOD.replace("mean:reach", "reach,mean:reach,mean:reach").replace(
        ".0\n", ".0,1,1\n"
    ),
    "a term that is a column": GOOD.replace("reach", "best"),
    "a term that is a line": GOOD.replace("reach", '"a\nb"'),
    "evaluations that are not a number": GOOD.replace(",70,", ",nan,"),
    "evaluations in parts": GOOD.replace(",70,", ",70.5,"),
    "a stage too early": GOOD.replace("\n2,1,", "\n2,0,"),
    "a best too large": GOOD.replace("70,2.0", "70,2e100"),
    "a mean that is not a number": GOOD.replace("1.0,1.0", "1.0,nan"),
    "a time backwards": GOOD.replace("0.125", "-1"),
    "empty lines": "\n" * 100_000,
    "rows too short": GOOD + "\n" * 100_000,
}


@pytest.mark.parametrize("content", DAMAGED.values(), ids=DAMAGED.keys())
def test_a_damaged_history_is_one_message(tmp_path, content):
    path = tmp_path / "history.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(RunError, match=r"history\.csv is damaged") as error:
        read_history(path)
    assert error.value.where == str(path)


@pytest.mark.parametrize(
    "space", [RealSpace(np.zeros(3), np.ones(3), ("a", "b", "c")), BitSpace(("a", "b", "c"))]
)
def test_bests_are_records_of_score_and_genome(tmp_path, space):
    path = tmp_path / "bests.bin"
    records = np.zeros(4, record_type(space))
    records["score"] = [1.5, -INF, 2.0, 3.0]
    records["genome"] = space.random(4, np.random.default_rng(0))
    assert records.dtype.itemsize == 8 + 3 * space.dtype.itemsize
    data = records.tobytes()
    for cut in range(len(data) + 1):
        path.write_bytes(data[:cut])
        read = read_records(path, record_type(space))
        assert read.tobytes() == data[: cut - cut % records.dtype.itemsize]
    assert len(read_records(tmp_path / "missing.bin", record_type(space))) == 0


def test_a_file_grows_and_is_cut_back(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"onetwo")
    file = AppendOnlyFile(path, 3)
    assert path.read_bytes() == b"one"
    file.append(b"thr")
    file.append(b"ee")
    file.flush()
    file.flush()
    assert path.read_bytes() == b"onethree"
    file.close()


def test_records_are_on_the_disk_when_they_are_flushed(tmp_path, monkeypatch):
    synced, real = [], os.fsync
    monkeypatch.setattr(
        os, "fsync", lambda fd: (synced.append((tmp_path / "f").read_bytes()), real(fd))
    )
    file = AppendOnlyFile(tmp_path / "f", 0)
    file.append(b"on")
    file.append(b"e")
    assert synced == []
    file.flush()
    assert synced == [b"one"]
    file.close()
