import csv
import io

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.executors import WorkerLostError
from gaitsim.evaluation.processes import ProcessExecutor
from gaitsim_studies.file import cells, parse_study, read_study
from gaitsim_studies.results import table
from gaitsim_studies.running import (
    read_result,
    recorded_generations,
    results,
    run_cells,
)

SMALL = """
name = "small"
experiments = ["millipede-random", "millipede-mutation"]
set = { "evolution.generations" = 6 }
repeats = 4
record_every = 4
target = 2.0
[axes]
"evolution.population" = { from = 5, to = 9, step = 2 }
"organism.pairs" = [2, 3]
"""


def test_cells_are_the_product_of_the_axes() -> None:
    found = cells(parse_study(SMALL, "small.toml"))
    assert len(found) == 2 * 3 * 2
    assert [cell.index for cell in found] == list(range(12))
    assert found[1].point == {
        "experiment": "millipede-random",
        "evolution.population": 5,
        "organism.pairs": 3,
    }
    assert found[3].experiment.evolution.population == 7
    assert found[3].experiment.evolution.generations == 6
    assert len({cell.experiment.seed for cell in found}) == 12


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("from = 5, to = 9|from = 9, to = 5", "the range from 9 to 5 is empty"),
        ("step = 2|step = 0", "greater than 0"),
        ("= [2, 3]|= []", "the axis has no values"),
        ("from = 5, to = 9, step = 2|from = 5, to = 9", "6 is odd|5 of 6"),
        ('"evolution.generations"|"evolution.population"', "is both an axis and in 'set'"),
        ("record_every|record_evry", "did you mean 'record_every'"),
        ('"millipede-mutation"|"millipede-mutatoin"', "did you mean 'millipede-mutation'"),
        ('name = "small"|name = "../small"', 'invalid name: "../small"'),
        ('name = "small"|name = "small"\nschema = 2', "newer version of gaitsim"),
        ('"organism.pairs"|"experiment"', "a column of the study's results"),
        ("= [2, 3]|= [2, 3000]", "small.toml, key organism.pairs"),
    ],
)
def test_each_problem_is_reported(change: str, says: str) -> None:
    before, after = change.split("|", 1)
    text = SMALL.replace(before, after)
    assert text != SMALL
    with pytest.raises(GaitsimError, match=says):
        cells(parse_study(text, "small.toml"), source="small.toml")


def test_steps_of_a_range_are_rounded_as_users_write_them() -> None:
    text = 'name = "s"\nexperiments = ["spider"]\n[axes]\n"mutation.rate" = '
    text += "{ from = 0.0, to = 0.5, step = 0.1 }"
    assert parse_study(text, "s").values("mutation.rate") == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]


DAMAGE = [b"", b"PK\x03\x04garbage", b"\x93NUMPY\x01\x00\x10\x00((((((((((((((((", b"\0" * 500]


def test_a_damaged_cell_is_missing(tmp_path) -> None:
    study = parse_study(SMALL, "small.toml")
    (cell, *_) = cells(study)
    list(run_cells(tmp_path, study, [cell], 1))
    best = read_result(tmp_path, study, cell)
    assert best.shape == (4, 2)
    (file,) = (tmp_path / "cells").iterdir()
    for damage in DAMAGE:
        file.write_bytes(damage)
        assert read_result(tmp_path, study, cell) is None, damage
    np.save(file, np.full((4, 2), np.nan))
    assert read_result(tmp_path, study, cell) is None


def test_a_changed_study_reuses_no_result(tmp_path) -> None:
    text = SMALL.replace("{ from = 5, to = 9, step = 2 }", "[5]")
    study = parse_study(text, "small.toml")
    list(run_cells(tmp_path, study, cells(study), 1))
    assert results(tmp_path, study, cells(study))[1] == []
    for before, after in (
        ("[2, 3]", "[4, 5]"),
        ("record_every = 4", "record_every = 5"),
        ("repeats = 4", "repeats = 5"),
    ):
        assert before in text
        changed = parse_study(text.replace(before, after), "small.toml")
        assert results(tmp_path, changed, cells(changed))[0] == [], after


def test_an_interrupted_study_resumes_to_the_same_table(tmp_path) -> None:
    study = parse_study(SMALL, "small.toml")
    every = cells(study)
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    whole.mkdir()
    cut.mkdir()
    list(run_cells(whole, study, every, 1))
    some = run_cells(cut, study, every, 2)
    done = [next(some) for _ in range(3)]
    some.close()  # as on Ctrl-C
    (damaged,) = (cut / "cells").glob(f"{done[0].index:06d}-*.npy")
    damaged.write_bytes(b"damaged")
    _, missing = results(cut, study, every)
    assert done[0] in missing
    assert done[1] not in missing
    list(run_cells(cut, study, missing, 2))
    tables = [table(study, results(folder, study, every)[0]) for folder in (whole, cut)]
    assert tables[0] == tables[1]
    rows = list(csv.DictReader(io.StringIO(tables[0])))
    assert len(rows) == 12 * 2
    assert rows[0]["evolution.population"] == "5"
    assert rows[1]["evaluations"] == str(6 * 5)
    assert float(rows[0]["q25"]) <= float(rows[0]["median"]) <= float(rows[0]["q75"])


def test_a_cell_that_kills_its_workers_is_reported(tmp_path, monkeypatch) -> None:
    def lost(*_: object) -> None:
        raise WorkerLostError("a worker process died 3 times on the same task")

    monkeypatch.setattr(ProcessExecutor, "each", lost)
    study = parse_study(SMALL, "small.toml")
    with pytest.raises(GaitsimError, match="a cell of the study"):
        list(run_cells(tmp_path, study, cells(study), 2))


def test_the_bundled_study_is_the_published_sweep() -> None:
    study, _ = read_study("millipede-operators")
    assert study.repeats == 100
    assert study.values("evolution.population") == list(range(3, 80, 2))
    found = cells(study)
    assert len(found) == 195
    assert recorded_generations(found[0].experiment, study.record_every).tolist() == list(
        range(2, 81, 2)
    )
