"""Summaries of the folders of studies and comparisons, including untrusted ones."""

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.storage.lock import RunLock
from gaitsim_studies.comparison import Sample, analyse, load_experiments
from gaitsim_studies.comparison_report import report, tables
from gaitsim_studies.confirmation import confirm
from gaitsim_studies.file import cells, experiment_files, parse_study
from gaitsim_studies.results import (
    LARGEST_REPORT,
    list_folders,
    read_report,
    sections,
    write_results,
)
from gaitsim_studies.running import results, run_cells

STUDY = """
name = "small"
description = "a small one"
experiments = ["millipede-random"]
set = { "evolution.generations" = 4 }
repeats = 20
target = 2.0
[axes]
"evolution.population" = [5, 9]
"""


@pytest.fixture
def studies(tmp_path, once):
    """Return a folder with a study that has finished one of two cells."""
    folder = tmp_path / "studies/small"

    def create():
        folder.mkdir(parents=True)
        study = parse_study(STUDY, "small.toml")
        for name, text in {"study.toml": STUDY, **experiment_files(study)}.items():
            (folder / name).write_text(text)
        list(run_cells(folder, study, cells(study)[:1], 1))

    once("study", folder, create)
    return tmp_path / "studies"


def finish(folder):
    study = parse_study(STUDY, "small.toml")
    list(run_cells(folder, study, cells(study)[1:], 1))
    found = results(folder, study, cells(study))[0]
    write_results(folder, study, found, confirm(folder, study, found, 1))
    return study


def only_folder(studies):
    (found,) = list_folders([studies])
    return found


class TestListFolders:
    @pytest.mark.slow
    def test_a_study_is_stopped_running_or_finished(self, studies):
        one = only_folder(studies)
        assert (one.kind, one.state, one.done, one.total) == ("study", "stopped", 1, 2)
        assert one.description == "a small one"
        lock = RunLock(studies / "small")
        assert only_folder(studies).state == "running"
        lock.release()
        finish(studies / "small")
        assert (only_folder(studies).state, only_folder(studies).done) == ("finished", 2)

    def test_a_comparison_is_finished_with_its_report(self, tmp_path):
        (tmp_path / "a-against-b").mkdir()
        assert list_folders([tmp_path]) == []
        (tmp_path / "a-against-b/1.toml").write_text("")
        (one,) = list_folders([tmp_path, tmp_path / "none"])
        assert (one.kind, one.state, one.total) == ("comparison", "stopped", None)
        (tmp_path / "a-against-b/report.md").write_text("# a against b\n")
        (one,) = list_folders([tmp_path])
        assert one.state == "finished"

    def test_a_damaged_study_has_a_problem(self, studies):
        (studies / "small/study.toml").write_text("name = 3\n")
        assert only_folder(studies).state == "damaged"
        assert "experiments is required" in str(only_folder(studies).problem)


class TestSections:
    @pytest.mark.slow
    def test_a_study_has_its_report_and_each_cell_with_its_interval(self, studies):
        folder = studies / "small"
        study = finish(folder)
        first, cheapest, every = sections(folder)
        assert first.texts == ("a small one",)
        assert cheapest.rows[0][0] == "millipede-random"
        assert [row[:2] for row in every.rows] == [
            ("millipede-random", "5"),
            ("millipede-random", "9"),
        ]
        (_, best), *_ = results(folder, study, cells(study))[0]
        last = best[:, -1]
        # 2.093024 is the 97.5 % quantile of Student's t with 19 degrees of freedom.
        half = 2.093024 * last.std(ddof=1) / np.sqrt(20)
        row = dict(zip(every.columns, every.rows[0], strict=True))
        assert row["generations"] == "4"
        assert row["mean ± 95 %"] == f"{last.mean():.4f} ± {half:.4f}"
        assert row["median"] == f"{np.median(last):.4f}"

    def test_a_comparison_has_all_its_tables(self):
        loaded = load_experiments(["millipede-random", "millipede-random"], {})
        scores = np.random.default_rng(0).random((5, 9)).cumsum(axis=1)
        found = analyse({key: Sample(one, scores) for key, one in loaded.items()}, 9999, [2.0])
        read = read_report(report(found, "gaitsim compare 'a b' c", []))
        titles = [one.title for one in read]
        assert titles[1:6] == [title for title, *_ in tables(found)]
        assert [len(one.rows) for one in read[1:6]] == [2, 1, 2, 2, 1]
        assert "given by the user" in read[4].texts[0]
        assert read[2].columns[3] == "A12"
        assert read[2].rows[0][-1] == "no"
        assert read[-1].command == "gaitsim compare 'a b' c"

    @pytest.mark.parametrize(
        ("name", "content", "says"),
        [
            ("report.md", b"\xff\xfe", "UTF-8"),
            ("report.md", b"x" * (LARGEST_REPORT + 1), "too large"),
            ("results.csv", b"a,b\n1,2\n", "columns"),
            ("results.csv", b"\xff\n", "cannot read"),
        ],
        ids=["no text", "too large", "other columns", "no table"],
    )
    def test_foreign_files_are_rejected(self, studies, name, content, says):
        (studies / "small" / name).write_bytes(content)
        with pytest.raises(GaitsimError, match=says):
            sections(studies / "small")
