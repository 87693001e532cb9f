"""Untrusted folders of studies: a study resumes, or ends with one message."""

import os
import shutil

import numpy as np
import pytest
from run_helpers import STUDY

from gaitsim.errors import GaitsimError, RunError
from gaitsim_studies.file import MOST_SCORES, cells, parse_study
from gaitsim_studies.plots import plot_surfaces
from gaitsim_studies.results import write_results
from gaitsim_studies.running import CELLS, FRESH, run_cells


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Return the folder of a finished study."""
    study = parse_study(STUDY, "small.toml")
    folder = tmp_path_factory.mktemp("study")
    (folder / "study.toml").write_text(STUDY)
    every = cells(study)
    for cell in every[::2]:
        (folder / f"{1 + cell.index // 2}.toml").write_text(cell.experiment.to_toml())
    for _ in run_cells(folder, study, every, 1):
        pass
    return folder


@pytest.fixture
def folder(studied, tmp_path):
    """Return a copy of the study, beside a folder outside it."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "file").write_text("theirs")
    return shutil.copytree(studied, tmp_path / "study")


def pipe(path):
    os.mkfifo(path)


def link(path):
    path.symlink_to(path.parents[1] / "outside" / "file")


def link_to_nothing(path):
    path.symlink_to(path.parents[1] / "outside" / "new")


def link_to_a_folder(path):
    path.symlink_to(path.parents[1] / "outside")


def endless(path):
    path.symlink_to("/dev/zero")


def huge(path):
    with path.open("wb") as file:
        file.truncate(10**11)


def directory(path):
    (path / "more").mkdir(parents=True)


ATTACKS = (pipe, link, link_to_nothing, link_to_a_folder, endless, huge, directory)


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS)
def test_attacks_on_each_file_of_a_study(attack, folder, gaitsim):
    whole = folder.parent / "whole"
    folder.rename(whole)
    for file in ("study.toml", "1.toml", "results.csv", "report.md", ".lock", CELLS, FRESH):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        path = folder / file
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        attack(path)
        # Attacks on files that the study replaces, or only locks, have no effect.
        harmless = {pipe: file in ("results.csv", "report.md"), directory: file in (CELLS, FRESH)}
        harmless[huge] = file in ("results.csv", "report.md", ".lock")
        if file in (CELLS, FRESH) and attack is directory:
            continue  # the attack changes nothing: it is a folder already
        said = gaitsim("study", folder, "--workers", 1, code=0 if harmless.get(attack) else 2)
        assert harmless.get(attack) or file in said.stderr
        outside = folder.parent / "outside"
        assert [entry.name for entry in outside.iterdir()] == ["file"]
        assert (outside / "file").read_text() == "theirs"


def test_the_largest_scores_are_summarised(tmp_path):
    study = parse_study(STUDY.replace('"organism.pairs" = [2]', ""), "s")
    found = [(cell, np.full((2, 3), score)) for cell in cells(study) for score in (1.7e308, -1e308)]
    write_results(tmp_path, study, found)
    plot_surfaces(tmp_path, study, found)
    assert "inf" in (tmp_path / "results.csv").read_text()
    (tmp_path / "surface-1.png").mkdir()
    with pytest.raises(RunError, match=r"surface-1\.png"):
        plot_surfaces(tmp_path, study, found)


def test_the_number_of_recorded_scores_is_limited():
    text = STUDY.replace("repeats = 2", "repeats = 1_000_000").replace("= 3 }", "= 100_000_000 }")
    with pytest.raises(GaitsimError, match=f"more than {MOST_SCORES:,} scores"):
        cells(parse_study(text, "s"))


def test_the_number_of_reported_problems_is_limited():
    text = STUDY.replace("[5, 7]", "{ from = 6, to = 100_000, step = 2 }")
    with pytest.raises(GaitsimError, match="cells after the first 20 were not checked"):
        cells(parse_study(text, "s"))
