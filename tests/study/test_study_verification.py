"""Verify a study: its cells, its fresh repeats, its table and its report."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from gaitsim.study.verification import verify_study

STUDY_TEXT = """
name = "small"
experiments = ["millipede-mutation"]
set = { "evolution.generations" = 2 }
repeats = 3
record_every = 2
TARGET
[axes]
"evolution.population" = [5]
"organism.pairs" = [1, 2, 3]
"""
TARGET = "target = { score = 1.0 }\nconfirm = { repeats = 100 }"


@pytest.fixture
def create(gaitsim, once):
    """A function that runs a study of three cells, with a line for a target."""

    def create(target=""):
        def run():
            Path("small.toml").write_text(STUDY_TEXT.replace("TARGET", target))
            gaitsim("study", "small.toml", "--workers", 1)

        return once(f"a verified study {target}", Path("studies/small"), run)

    return create


@pytest.fixture
def study(create):
    return create()


def test_a_study_is_identical(study, gaitsim):
    verdict = verify_study(study, everything=True, workers=1)
    assert verdict.identical, verdict.differences
    assert verdict.complete
    lines = gaitsim("verify", study, "--workers", 1).stdout.splitlines()
    assert lines[:2] == ["studies/small: identical", "3 of 3 cells run again: 0 to 2"]
    found = json.loads(gaitsim("verify", study, "--all", "--json", "--workers", 1).stdout)
    assert (found["identical"], found["complete"], found["again"]) == (True, True, [0, 1, 2])


def raise_score(file):
    scores = np.load(file)
    scores = scores + 1e-9
    np.save(file, scores)


def other_table(folder):
    text = (folder / "results.csv").read_text()
    (folder / "results.csv").write_text(text.replace(",3,", ",4,", 1))


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("tamper", "message"),
    [
        (lambda folder: raise_score(sorted((folder / "cells").iterdir())[2]), "cell 2"),
        (lambda folder: sorted((folder / "cells").iterdir())[1].unlink(), "cell 1 is missing"),
        (other_table, "results.csv does not follow"),
        (lambda folder: (folder / "report.md").write_text("# better"), "report.md does not"),
        (lambda folder: (folder / "report.md").unlink(), "report.md does not"),
    ],
    ids=["score", "cell", "table", "report", "no report"],
)
def test_tampering_is_found(study, tamper, message, gaitsim):
    tamper(study)
    answer = gaitsim("verify", study, "--all", "--workers", 1, code=1).stdout
    assert answer.startswith("studies/small: different\n")
    assert message in answer


@pytest.mark.slow
def test_fresh_repeats_are_compared(create):
    study = create("target = 1.0")
    verdict = verify_study(study, workers=1)
    assert (verdict.identical, verdict.complete) == (True, False)
    first, second, *_ = sorted((study / "confirmation").iterdir())
    raise_score(first)
    second.unlink()
    found = verify_study(study, everything=True, workers=1).differences
    assert f"the fresh repeats in confirmation/{first.name} differ" in found
    assert f"confirmation/{second.name} is missing" in found


def test_a_cell_cannot_be_replaced_by_another(study):
    first, second, *_ = sorted((study / "cells").iterdir())
    shutil.copy(first, second)
    assert not verify_study(study, workers=1).identical


def test_options_of_runs_do_not_apply_to_studies(study, gaitsim):
    stderr = gaitsim("verify", study, "--generations", "1", code=2).stderr
    assert "a study has no generations" in stderr
