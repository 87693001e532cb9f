"""Comparison of runs: differences, the screen and the command."""

import json
import os
import shutil
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from waiting import app_until

from gaitsim.experiment import Evolution, ExperimentOutline, Islands, Worlds
from gaitsim.storage.compare_runs import (
    ABSENT,
    RunsReader,
    comparison_table,
    differences,
    fair_axis,
    scoring_warning,
)
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens.compare import Compare
from gaitsim.tui.widgets.curves import Curves


def outline(seed=1, **sections):
    return ExperimentOutline(
        "any", "never shown", seed, {}, Evolution(), Islands(), Worlds(), sections
    )


class TestDifferences:
    def test_equal_options_are_left_out(self):
        one = outline(mutation={"plugin": "gaussian", "rate": 0.1})
        other = outline(mutation={"plugin": "gaussian", "rate": 0.2})
        (found,) = differences([[(1, one)], [(1, other)]])
        assert (found.key, found.values) == ("mutation.rate", ("0.1", "0.2"))

    def test_names_are_not_compared(self):
        assert not differences([[(1, outline())], [(1, replace(outline(), name="another"))]])

    def test_an_option_of_only_one_experiment(self):
        one, other = outline(mutation={"plugin": "a", "rate": 1}), outline(mutation={"plugin": "b"})
        found = {row.key: row.values for row in differences([[(1, one)], [(1, other)]])}
        assert found == {"mutation.plugin": ("a", "b"), "mutation.rate": ("1", ABSENT)}

    def test_a_change_during_a_run_has_its_generation(self):
        one, other = outline(mutation={"rate": 0.1}), outline(mutation={"rate": 0.2})
        stages = [(1, one), (11, other), (21, other), (31, one)]
        (found,) = differences([stages, [(1, one)]])
        assert found.values == ("0.1, from 11: 0.2, from 31: 0.1", "0.1")

    @pytest.mark.parametrize(
        ("sections", "message"),
        [
            ({"mutation": {"plugin": "b"}}, ""),
            ({"fitness": {"plugin": "b", "k": 1}}, "are not comparable: fitness.plugin differs."),
            ({"fitness": {"plugin": "a", "k": 2}}, "are not comparable: fitness.k differs."),
            (
                {"organism": {"plugin": "a", "legs": 6}},
                "may not be comparable: organism.legs differs.",
            ),
        ],
    )
    def test_a_warning_names_the_options_that_make_scores_incomparable(self, sections, message):
        same = {"organism": {"plugin": "a", "legs": 8}, "fitness": {"plugin": "a", "k": 1}}
        one, other = outline(**same), outline(**same | sections)
        for runs in ([[(1, one)], [(1, other)]], [[(1, one), (9, other)]]):
            assert scoring_warning(differences(runs)).endswith(message)
        assert not scoring_warning(differences([[(1, one)], [(1, one)]]))


@pytest.fixture
def make_run(walk):
    """Return a function that creates a finished run of puppets."""

    def make(name, *overrides):
        path = walk(name, 5, *overrides)
        fix_seconds(path)
        return path

    return make


def fix_seconds(path):
    """Set the time of every generation to half a second, as measured times differ."""
    lines = (path / "history.csv").read_text().splitlines()
    at = lines[0].split(",").index("seconds")
    rows = [line.split(",") for line in lines]
    for row in rows[1:]:
        row[at] = "0.5"
    (path / "history.csv").write_text("\n".join(map(",".join, rows)) + "\n")


@pytest.fixture
def two(make_run):
    return [make_run("one"), make_run("two", "seed=2", "mutation.plugin=puppet-jitter")]


class TestRuns:
    def test_the_table_lists_the_results_of_each_run(self, two):
        courses = RunsReader(two).read()
        run = RunSnapshot(two[0])
        best = run.individual()
        number, score = best.generation, best.score
        rows = {row.key: row.values for row in comparison_table(courses)}
        assert rows["generations"] == ("5", "5")
        assert rows["found in generation"][0] == str(number)
        assert rows["best score"][0] == f"{score:.4f}".replace("-", "−")
        assert rows["seed"] == ("1", "2")
        assert "mutation.plugin" not in rows

    def test_runs_with_different_populations_are_compared_by_evaluations(self, two, make_run):
        large = make_run("large", "evolution.population=12")
        courses = RunsReader([two[0], large]).read()
        spent = [one.history["evaluations"] for one in courses]
        assert spent[0][-1] < spent[1][-1]
        assert (fair_axis(courses), fair_axis(RunsReader(two).read())) == (
            "evaluations",
            "generation",
        )
        shared = int(spent[0][-1])
        within = courses[1].history["best"][spent[1] <= shared].max()
        rows = {row.key: row.values for row in comparison_table(courses)}
        assert rows[f"best of {shared:,} evaluations"] == (
            rows["best score"][0],
            f"{within:.4f}".replace("-", "−"),
        )

    def test_runs_with_equal_names_are_labelled_by_their_folders(self, two):
        shutil.copytree(two[0], "elsewhere/one")
        labels = [one.label for one in RunsReader([two[0], Path("elsewhere/one")]).read()]
        assert labels == ["runs/one", "elsewhere/one"]

    def test_an_unreadable_run_has_a_problem(self, two):
        (two[1] / "history.csv").write_text("nonsense\n")
        one, damaged, missing = RunsReader([*two, Path("runs/missing")]).read()
        assert one.problem is None
        assert "history.csv is damaged" in str(damaged.problem)
        assert "cannot read" in str(missing.problem)
        assert [row.values[1:] for row in comparison_table([one, damaged, missing])] == [
            ("–", "–")
        ] * 5


@asynccontextmanager
async def compare(runs, size=(80, 24)):
    app = GaitsimApp(Path("runs"))
    async with app.run_test(size=size) as pilot:
        app.screen.show_screen("compare.Compare", list(runs))
        await settled(pilot)
        yield app.screen, pilot


async def settled(pilot):
    await pilot.pause()
    await pilot.app.workers.wait_for_complete()
    await pilot.pause()


def shown(screen):
    return screen.query_one(Curves).series


def cells(screen):
    grid = screen.query_one("#table")
    return {
        str(row[0]): [str(cell) for cell in row[1:]]
        for row in (grid.get_row_at(at) for at in range(grid.row_count))
    }


class TestScreen:
    async def test_keys_cycle_through_quantities_and_axes(self, two):
        async with compare(two) as (screen, pilot):
            history = RunSnapshot(two[0]).history
            for quantity in ("mean", "median", "diversity", "best"):
                await pilot.press("o")
                assert np.array_equal(shown(screen)[0].y, history[quantity])
                assert quantity in screen.sub_title
            await pilot.press("x")
            assert np.array_equal(shown(screen)[0].x, history["evaluations"])
            await pilot.press("x", "x")
            assert np.array_equal(shown(screen)[0].x, history["generation"])

    async def test_stages_are_listed_and_marked(self, two, gaitsim):
        gaitsim("resume", "one", "--generations", "8", "--set", "fitness.price=0.3")
        async with compare(two) as (screen, _pilot):
            assert cells(screen)["fitness.price"] == ["0.1, from 6: 0.3", "0.1"]
            assert shown(screen)[0].stages == (5,)
            message = str(screen.query_one("#warning").render())
            assert "are not comparable: fitness.price differs" in message
            assert screen.query_one(Curves).marks == (6.0,)

    async def test_a_run_is_chosen_and_replayed_beside_the_other(self, two):
        async with compare(two) as (screen, pilot):
            asked = []
            screen.show_screen = lambda *what, beside=None: asked.append((*what, beside))
            await pilot.press("right", "r", "enter")
            assert asked == [("replay.Replay", two[1], two[0]), ("live.Live", two[1], None)]

    async def test_an_evolving_run_is_reread(self, two, monkeypatch):
        monkeypatch.setattr("gaitsim.tui.screens.compare.EVERY", 0.05)
        async with compare(two) as (screen, pilot):
            before = shown(screen)
            await pilot.pause(0.2)
            assert shown(screen) is before or shown(screen) == before
            shutil.copytree(two[1], two[0], dirs_exist_ok=True)
            os.utime(two[0] / "population.pickle", ns=(1, 1))

            def same():  # a run may be unreadable while it is copied
                curves = shown(screen)
                return len(curves) == 2 and np.array_equal(curves[0].y, curves[1].y)

            await app_until(pilot, same)


def test_looks(two, snap_compare):
    async def show(pilot):
        pilot.app.screen.show_screen("compare.Compare", two)
        await settled(pilot)
        assert isinstance(pilot.app.screen, Compare)

    assert snap_compare(GaitsimApp(Path("nowhere")), terminal_size=(80, 24), run_before=show)


class TestCommand:
    def test_the_command_prints_curves_and_differences(self, gaitsim, two):
        output = gaitsim("differences", "one", "two").stdout
        assert "best score by generation" in output
        assert "┤" in output
        assert [line.split() for line in output.splitlines() if line.startswith("seed")] == [
            ["seed", "1", "2"]
        ]

    def test_json_has_numbers(self, gaitsim, two):
        output = json.loads(gaitsim("differences", *two, "--json").stdout)
        best = RunSnapshot(two[0]).individual()
        number, score = best.generation, best.score
        assert output["runs"][0] | {"score": score, "generation": number} == output["runs"][0]
        assert output["options"] == {"seed": ["1", "2"]}
        assert output["warning"] is None

    def test_a_warning_is_printed_drawn_and_in_json(self, gaitsim, make_run):
        runs = [make_run("one"), make_run("dear", "fitness.price=0.3")]
        message = "are not comparable: fitness.price differs"
        done = gaitsim("differences", *runs, "--plot", "a.svg")
        assert message in done.stderr
        assert message in Path("a.svg").read_text()
        assert message in json.loads(gaitsim("differences", *runs, "--json").stdout)["warning"]


class TestPlay:
    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ((), "not a terminal"),
            (("--at", "99"), "99 s is after the end of the motion"),
            (("--speed", "0"), "invalid speed: 0"),
            (("--generation", "9"), "no generation 9"),
        ],
    )
    def test_invalid_input_is_reported(self, gaitsim, two, options, message):
        assert message in gaitsim("play", "one", *options, code=2).stderr
