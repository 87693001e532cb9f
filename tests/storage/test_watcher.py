"""Overviews of runs: their contents, and that only changed runs are read."""

import math
import shutil

import numpy as np
import pytest
from run_helpers import evolve_run

from gaitsim.errors import RunError
from gaitsim.storage.growing import POINTS, HistoryBuffer, RunsWatcher, curve, overview
from gaitsim.storage.snapshot import RunSnapshot


class TestOverview:
    def test_it_describes_the_run_and_its_progress(self, walk):
        path = walk("walk", 3, "seed=7")
        found, history = overview(path), RunSnapshot(path).history
        assert (found.name, found.state, found.problem) == ("walk", "stopped", None)
        assert (found.generation, found.generations, found.stage, found.seed) == (3, 5, 1, 7)
        assert found.plugins["organism"] == "puppet"
        assert found.best == history["best"].max()
        assert found.curve == tuple(history["best"])
        assert found.seconds == pytest.approx(history["seconds"].sum())
        assert found.changed == pytest.approx((path / "history.csv").stat().st_mtime, abs=5)

    def test_the_best_score_is_of_the_current_fitness(self, walk):
        path = walk("walk", 2)
        evolve_run(path, 4, "fitness.price=0.9")
        found = overview(path)
        assert found.stage == 2
        assert found.best == RunSnapshot(path).history["best"][2:].max()
        assert len(found.curve) == 4

    @pytest.mark.parametrize(
        ("file", "content"),
        [
            ("experiment.toml", "schema = 1\n[evolution"),
            ("population.pickle", "x"),
            ("history.csv", "\x00\n"),
        ],
    )
    def test_a_damaged_run_has_its_reason(self, walk, file, content):
        path = walk()
        for name in {file, file.replace("population", "population.previous")}:
            (path / name).write_text(content)
        found = overview(path)
        assert found.state == "damaged"
        assert found.problem.what

    def test_a_deleted_run_has_no_overview(self, tmp_path):
        assert overview(tmp_path / "nowhere") is None


class TestWatch:
    def test_only_changed_runs_are_read(self, walk, monkeypatch, checkpoint_reads):
        paths = [walk("a", 2), walk("b", 2)]
        watch, read = RunsWatcher(paths[0].parent), checkpoint_reads
        monkeypatch.setattr("gaitsim.storage.growing.READ_INTERVAL", 0)
        first = watch.poll()
        assert read == [path / "population.pickle" for path in paths]
        read.clear()
        assert watch.poll() == first
        assert not read
        evolve_run(paths[1], 3)
        read.clear()
        assert [found.generation for found in watch.poll()] == [2, 3]
        assert read == [paths[1] / "population.pickle"]

    def test_a_run_that_is_slow_to_read_is_read_less_often(self, walk, monkeypatch):
        path = walk("a", 2)
        watch = RunsWatcher(path.parent)
        monkeypatch.setattr("gaitsim.storage.growing.READ_INTERVAL", 1e9)
        watch.poll()
        evolve_run(path, 3)
        assert [found.generation for found in watch.poll()] == [2]

    def test_runs_come_and_go(self, walk):
        one, other = walk("a", 1), walk("b", 1)
        watch = RunsWatcher(one.parent)
        assert {found.name for found in watch.poll()} == {"a", "b"}
        shutil.rmtree(one)
        assert [found.name for found in watch.poll()] == ["b"]
        walk("c", 1)
        assert {found.name for found in watch.poll()} == {"b", "c"}
        shutil.rmtree(other)

    def test_a_missing_folder_has_no_runs(self, tmp_path):
        assert RunsWatcher(tmp_path / "runs").poll() == []

    def test_a_file_in_place_of_the_folder_is_an_error(self, tmp_path):
        (tmp_path / "runs").write_text("")
        with pytest.raises(RunError):
            RunsWatcher(tmp_path / "runs").poll()


class TestCurve:
    def test_rows_from_the_first_generation_replace_earlier_ones(self):
        history = HistoryBuffer(rows([1.0, 2.0]))
        history.extend(rows([3.0], first=3))
        assert (curve(history["best"]), history["seconds"].sum()) == ((1.0, 2.0, 3.0), 1.5)
        history.extend({})
        history.extend(rows([4.0, 5.0]))
        assert (curve(history["best"]), history["seconds"].sum()) == ((4.0, 5.0), 1.0)

    @pytest.mark.parametrize("count", [POINTS - 1, POINTS, POINTS + 1, 12345])
    def test_a_long_curve_is_thinned_and_keeps_its_peaks(self, count):
        values = np.sin(np.arange(count) / 50.0)
        values[count // 3] = 99.0
        points = curve(values)
        assert POINTS // 2 <= len(points) <= POINTS
        assert max(points) == 99.0
        stride = 2 ** math.ceil(math.log2((count + 1) / POINTS)) if count >= POINTS else 1
        blocks = [max(values[at : at + stride]) for at in range(0, count, stride)]
        assert points == tuple(blocks)

    def test_generations_in_which_all_failed_are_gaps(self):
        values = np.full(300, -np.inf)
        values[7] = 1.0
        assert [point for point in curve(values) if not math.isnan(point)] == [1.0]


def rows(best, first=1):
    count = len(best)
    return {
        "generation": np.arange(first, first + count),
        "best": np.asarray(best, float),
        "seconds": np.full(count, 0.5),
    }
