"""Verify a study: its cells, its fresh repeats, its table and its report."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim_studies.verification import choose, verify_study

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
    assert {line.split()[0] for line in lines[3:]} == {
        "study.toml", "1.toml", "cells/", "results.csv", "report.md"
    }  # fmt: skip
    found = json.loads(gaitsim("verify", study, "--all", "--json", "--workers", 1).stdout)
    assert (found["identical"], found["complete"], found["again"]) == (True, True, [0, 1, 2])
    assert found["study"] == "studies/small"


def raise_score(file):
    scores = np.load(file)
    scores = scores + 1e-9
    np.save(file, scores)


def replaced(name, old, new):
    def tamper(folder):
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return tamper


def cell(folder, number):
    return sorted((folder / "cells").iterdir())[number]


def huge(file):
    os.truncate(file, 10**11)


TAMPERINGS = {
    "a score": (lambda folder: raise_score(cell(folder, 2)), "cells/000002-"),
    "a cell deleted": (lambda folder: cell(folder, 1).unlink(), "cell 1 is missing"),
    "cells swapped": (
        lambda folder: swap(cell(folder, 0), cell(folder, 1)),
        "cells/000000-",
    ),
    "a huge cell": (lambda folder: huge(cell(folder, 1)), "cell 1 is missing or damaged"),
    "the table": (replaced("results.csv", ",3,", ",4,"), "results.csv"),
    "the report": (replaced("report.md", "#", "##"), "report.md"),
    "a value of an axis": (replaced("study.toml", "[1, 2, 3]", "[1, 2, 4]"), "cell 2 is missing"),
    "a target": (replaced("study.toml", "repeats", "target = -1e9\nrepeats"), "report.md"),
}
UNVERIFIABLE = {
    "the repeats": replaced("study.toml", "repeats = 3", "repeats = 2"),
    "an option": replaced("1.toml", '"forward"', '"backward"'),
    "no study": lambda folder: (folder / "study.toml").write_text(""),
}


def swap(one, other):
    contents = one.read_bytes(), other.read_bytes()
    other.write_bytes(contents[0])
    one.write_bytes(contents[1])


@pytest.mark.sampled
@pytest.mark.parametrize(("tamper", "message"), TAMPERINGS.values(), ids=TAMPERINGS)
def test_tampering_is_found(study, tamper, message):
    tamper(study)
    found = verify_study(study, everything=True, workers=1).differences
    assert message in "\n".join(map(str, found))


@pytest.mark.sampled
@pytest.mark.parametrize("tamper", UNVERIFIABLE.values(), ids=UNVERIFIABLE)
def test_results_of_other_options_are_not_verified(study, tamper):
    tamper(study)
    with pytest.raises(GaitsimError):
        verify_study(study, workers=1)


@pytest.mark.slow
def test_fresh_repeats_are_compared(create):
    study = create("target = 1.0")
    verdict = verify_study(study, workers=1)
    assert (verdict.identical, verdict.complete) == (True, False)
    first, second, *_ = sorted((study / "confirmation").iterdir())
    raise_score(first)
    second.unlink()
    found = {one.file for one in verify_study(study, everything=True, workers=1).differences}
    assert found == {f"confirmation/{one.name}" for one in (first, second)}


def test_the_cells_that_are_run_again_cannot_be_foreseen():
    drawn = [choose(range(1000), 10) for _ in range(9)]
    assert len({*map(tuple, drawn)}) > 1
    assert all(one == sorted({*one}) and len(one) == 10 for one in drawn)
    assert choose([4, 7], 10) == [4, 7]
