"""Untrusted folders of studies: a study resumes, or ends with one message."""

import shutil

import numpy as np
import pytest
from hostile import ATTACKS
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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pipe", "link to a file", "link to nothing", "endless", "huge"])
def test_attacks_on_each_file_of_a_study(name, folder, gaitsim):
    whole, outside = folder.parent / "whole", folder.parent / "outside"
    folder.rename(whole)
    for file in ("study.toml", "1.toml", "results.csv", "report.md", ".lock", CELLS, FRESH):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        path = folder / file
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        ATTACKS[name](path, b"", outside)
        # Attacks on files that the study replaces, or only locks, have no effect.
        replaced = file in ("results.csv", "report.md")
        harmless = {"pipe": replaced, "huge": replaced or file == ".lock"}.get(name)
        said = gaitsim("study", folder, "--workers", 1, code=0 if harmless else 2)
        assert harmless or file in said.stderr
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
