"""Home: runs listed, followed, sorted, filtered, renamed and deleted."""

import os
import shutil
from pathlib import Path
from threading import Event

import pytest
from rich.cells import cell_len
from textual.widgets import Input, Static
from textual.widgets._footer import FooterKey

from gaitsim.live.process import background_state, start_detached
from gaitsim.render.terminal.text import ago, duration, number
from gaitsim.storage import growing
from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import list_trash, read_note, read_tags, write_tags
from gaitsim.storage.query import value_of
from gaitsim.tui.config import read_config
from gaitsim.tui.formatting import clip_name
from gaitsim.tui.screens import run_preview
from gaitsim.tui.screens.home import Home
from gaitsim.tui.widgets.run_table import MARK, NARROW, NO_MARK, layout


def cells(driver):
    """Return the table as a list of rows of text."""
    table = driver.screen.query_one("#runs")
    return [
        [cell.plain.strip() for cell in table.cells(row)] for row in table.shown if table.columns
    ]


def rows(driver):
    """Return the rows without marks."""
    return [[row[0].removeprefix(MARK).removeprefix(NO_MARK), *row[1:]] for row in cells(driver)]


def names(driver):
    return [row[0] for row in rows(driver)]


def marks(driver):
    return [row[0].startswith(MARK) for row in cells(driver)]


async def look(driver):
    await driver.screen.look().wait()
    await driver.pilot.pause()


@pytest.mark.parametrize(
    "name", ["", "walker", "walker-rough-2", "長い名前長い名前", "a\x1b[2J" * 9]
)
@pytest.mark.parametrize("width", [1, 2, 3, 8, 12, 13])
def test_a_clipped_name_fits_its_width(name, width):
    assert cell_len(clip_name(name, width)) <= width


def test_ages_and_durations_use_the_same_units():
    assert [ago(seconds) for seconds in (1, 50, 59 * 60, 7300, 3e6)] == [
        "now", "50 s ago", "59 min ago", "2 h ago", "34 d ago",
    ]  # fmt: skip
    assert duration(420) == "7 min 0 s"


class TestTable:
    async def test_a_row_has_name_body_generation_best_score_and_state(self, walk, drive):
        path = walk()
        (path / ".lock").touch()
        async with drive() as driver:
            row = rows(driver)[0]
            assert row[0] == "walk"
            assert {"puppet", "3/5", "■ stopped"} <= set(row)
            table = driver.screen.query_one("#runs")
            assert sum(width + 2 for width in table.columns.values()) < table.size.width

    def test_the_columns_fit_the_table_at_any_width(self):
        for width in range(20, 300):
            found = layout(width, tagged=True)
            assert sum(cells + 2 for cells in found.values()) <= width - 1
            assert width < 80 or {*NARROW, "curve"} <= {*found}
            assert ("tag" in found) == (width >= 120)

    async def test_an_empty_folder_shows_how_to_create_a_run(self, here, drive):
        async with drive() as driver:
            text = driver.text("#empty")
            assert "There are no runs in runs/ yet" in text
            assert "gaitsim run spider" in text
            assert not driver.offered() & {
                "home.delete",
                "home.export",
                "home.replay",
                "home.filter",
            }
            assert {"home.new", "home.plugins", "app.help", "app.quit"} <= driver.offered()

    async def test_a_damaged_run_shows_its_problem_and_is_not_opened(self, walk, drive):
        path = walk()
        (path / "experiment.toml").write_text("[[[")
        async with drive() as driver:
            assert "✗ damaged" in rows(driver)[0]
            assert "not valid TOML" in driver.text("#details")
            assert not driver.offered() & {"home.export", "home.replay"}
            assert "home.delete" in driver.offered()
            await driver.press("enter")
            assert isinstance(driver.screen, Home)
            assert "not valid TOML" in driver.notifications()

    async def test_curves_of_one_body_and_fitness_share_a_scale(self, walk, drive):
        walk("a")
        walk("b", 3, "seed=7")
        async with drive(size=(160, 48)) as driver:
            table = driver.screen.query_one("#runs")
            curves = [run.curve for run in table.shown]
            scores = [score for curve in curves for score in curve]
            assert {table.scale(run) for run in table.shown} == {(min(scores), max(scores))}
            low, high = number(min(scores)), number(max(scores))
            assert f"curve from {low} to {high}" in driver.text("#details")


class TestFollowing:
    async def test_locking_and_unlocking_a_run_changes_its_state(self, walk, drive):
        path = walk()
        async with drive() as driver:
            lock = RunLock(path)
            await look(driver)
            assert "● running" in rows(driver)[0]
            assert "1 running" in driver.screen.sub_title
            lock.release()
            await look(driver)
            assert "■ stopped" in rows(driver)[0]

    async def test_the_cursor_stays_on_its_run_when_runs_are_added(self, walk, drive):
        walk("b")
        async with drive() as driver:
            await driver.press("s")  # by name, the first column, after the last one
            while driver.screen.query_one("#runs").sort != "name":
                await driver.press("s")
            for name in ("a", "c"):
                walk(name)
            await look(driver)
            assert names(driver) == ["a", "b", "c"]
            assert driver.screen.query_one("#runs").run.name == "b"
            shutil.rmtree("runs/b")
            await look(driver)
            assert names(driver) == ["a", "c"]
            assert driver.screen.query_one("#runs").run.name == "c"


class TestManyRuns:
    async def test_runs_are_listed_while_the_scan_continues_and_keys_work(
        self, walk, drive, monkeypatch
    ):
        for changed, name in enumerate("abc"):
            os.utime(walk(name, 0) / "experiment.toml", (changed, changed))
        read, gate = growing.RunFollower.poll, Event()

        def slow(follower):
            if follower.path.name != "c":
                assert gate.wait(60)
            return read(follower)

        monkeypatch.setattr(growing.RunFollower, "poll", slow)
        async with drive(ready=False) as driver:
            home = driver.screen
            await driver.until(lambda: home.query("#runs") and names(driver) == ["c"])
            assert "1 of 3 runs read" in home.sub_title
            await driver.press("space")
            assert marks(driver) == [True]
            gate.set()
            await driver.until(lambda: names(driver) == ["c", "b", "a"])
            await driver.until(lambda: "3 runs" in home.sub_title)
            assert marks(driver) == [True, False, False]
            assert home.query_one("#runs").run.name == "c"


class TestSortingAndFiltering:
    @pytest.fixture
    def three(self, walk):
        walk("one", 3)
        walk("two", 1)
        walk("three", 5)

    async def test_sorting_by_time_then_by_any_column_in_both_directions(self, three, drive):
        async with drive() as driver:
            assert names(driver) == ["three", "two", "one"]
            table = driver.screen.query_one("#runs")
            for name in ("generation", "name", "age"):
                table.sort_by(name)
                shown = [value_of(run, name) for run in table.shown]
                assert shown == sorted(shown, reverse=name == "generation")
                before = names(driver)
                await driver.press("S")
                assert names(driver) == before[::-1]

    async def test_a_query_selects_runs_and_an_invalid_word_is_reported(self, three, drive):
        write_tags(Path("runs/two"), ["good"])
        async with drive() as driver:
            home = driver.screen
            await driver.press("slash")
            for query, found, problem in (
                ("generation>2", ["three", "one"], ""),
                ("name:t generation>", ["three", "two"], "is not a number"),
                ("name:t generation>1 evolution.x:1", ["three"], "unknown key"),
                ("-tag:good", ["three", "one"], ""),
                ("state:nowhere", ["three", "two", "one"], "unknown state"),
                ("tag:good", ["two"], ""),
            ):
                home.query_one("#filter").value = query
                await driver.until(lambda query=query: home.filter == query)
                assert names(driver) == found
                line = home.query_one("#filter-problem")
                assert (problem in str(line.render())) if problem else not line.display
            assert "1 of 3 runs" in home.sub_title
            await driver.press("enter", "escape")
            assert "3 runs" in home.sub_title

    @pytest.mark.slow
    async def test_columns_are_chosen_ordered_and_remembered(self, three, drive, config):
        settings = config("")
        async with drive(config=settings, size=(110, 34)) as driver:
            await driver.press("C")
            asked = await driver.at("Ask")
            answer = asked.query_one("#answer", Input)
            assert answer.value == "name, body, fitness, generation, score, state, age"
            answer.value = "name, evolution.popolation"
            await driver.press("enter")
            assert "did you mean 'evolution.population'?" in driver.text("#ask-problem")
            answer.value = "name, generation, score, "
            await driver.press("end")
            await driver.type("evolution.pop")
            await driver.press("right")
            assert answer.value == "name, generation, score, evolution.population"
            await driver.press("enter")
            await driver.at("Home")
            table = driver.screen.query_one("#runs")
            assert [*table.chosen] == ["name", "generation", "score", "evolution.population"]
            population = table.run.options["evolution.population"]
            await driver.until(lambda: str(population) in rows(driver)[0])
            table.sort_by("evolution.population")
            await driver.until(lambda: "sort" in settings.path.read_text())
        async with drive(config=read_config(settings.path), size=(110, 34)) as driver:
            table = driver.screen.query_one("#runs")
            assert (table.chosen[-1], table.sort) == ("evolution.population",) * 2
            await driver.press("C")
            asked = await driver.at("Ask")
            asked.query_one("#answer", Input).value = ""
            await driver.press("enter")
            await driver.at("Home")
            assert not driver.screen.query_one("#runs").chosen


class TestDeleting:
    async def test_a_run_is_deleted_after_confirmation(self, walk, drive):
        path = walk()
        async with drive() as driver:
            await driver.press("d")
            await driver.at("Confirm")
            await driver.press("escape")
            await driver.at("Home")
            assert path.exists()
            await driver.press("d")
            asked = await driver.at("Confirm")
            texts = [str(one.render()) for one in asked.query(Static)]
            assert texts[0] == "Delete the run walk?"
            assert "It moves to the trash for 30 days: z restores" in texts[1]
            assert asked.query_one(".dialog").border_subtitle == "y: delete · n or esc: cancel"
            await driver.press("y")
            await driver.until(lambda: not path.exists())
            await driver.until(lambda: driver.screen.query_one("#empty").display)
            assert "home.undo" in driver.offered()
            await driver.press("z")
            await driver.until(lambda: names(driver) == ["walk"])
            assert path.exists()
            assert "home.undo" not in driver.offered()

    async def test_marked_runs_are_deleted_after_one_question_except_live_ones(self, walk, drive):
        for name in ("a", "b", "c", "kept"):
            walk(name, 0)
        lock = RunLock(Path("runs/c"))
        async with drive() as driver:
            table = driver.screen.query_one("#runs")
            for run in [*table.shown]:
                if run.name != "kept":
                    table.marked.add(run.path)
            await driver.press("d")
            asked = await driver.at("Confirm")
            texts = [str(one.render()) for one in asked.query(Static)]
            assert texts[0] == "Delete 2 runs?"
            assert {"a", "b"} <= {*texts[1].splitlines()[0].split(", ")}
            assert "Not deleted, because they evolve: c." in texts[1]
            await driver.press("y")
            await driver.until(lambda: sorted(names(driver)) == ["c", "kept"])
            assert not Path("runs/a").exists()
        lock.release()

    async def test_the_trash_lists_runs_and_restores_or_deletes_them(self, walk, drive):
        for name in ("a", "b"):
            walk(name, 0)
        async with drive() as driver:
            await driver.press("Z")
            await driver.until(lambda: "The trash is empty" in driver.notifications())
            await driver.press("a", "d")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: not driver.screen.listed)
            await driver.press("Z")
            await driver.at("PickTrashed")
            await driver.press("enter")
            await driver.until(lambda: len(list_trash(Path("runs"))) == 1)
            await driver.until(lambda: driver.app.screen.query("#items"))
            await driver.press("x")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: not list_trash(Path("runs")))
            await driver.until(lambda: len(names(driver)) == 1)
            assert "home.undo" not in driver.offered()


class TestMarks:
    async def test_ranges_all_and_the_others_are_marked(self, walk, drive):
        for name in "abcde":
            walk(name, 0)
        async with drive() as driver:
            table = driver.screen.query_one("#runs")
            await driver.press("space", "down", "V")
            assert marks(driver) == [True, True, True, False, False]
            assert "3 marked" in driver.screen.sub_title
            await driver.press("i")
            assert marks(driver) == [False, False, False, True, True]
            await driver.press("a")
            assert all(marks(driver))
            await driver.press("A")
            assert not table.marked
            await driver.press("space", "escape")
            assert not table.marked
            await driver.pilot.click("#runs", offset=(20, 1), control=True)
            await driver.pilot.click("#runs", offset=(20, 4), shift=True)
            assert marks(driver) == [True, True, True, True, False]

    async def test_tags_of_all_marked_runs_are_edited_and_restored(self, walk, drive):
        a, b = walk("a", 0), walk("b", 0)
        write_tags(a, ["old", "good"])
        async with drive() as driver:
            await driver.press("a", "T")
            asked = await driver.at("Ask")
            assert "good (1)" in "".join(str(one.render()) for one in asked.query(Static))
            asked.query_one(Input).value = "+new old"
            await driver.press("enter")
            assert "cannot be mixed" in driver.text("#ask-problem")
            asked.query_one(Input).value = "+new -old"
            await driver.press("enter")
            await driver.until(lambda: read_tags(b) == ("new",))
            assert read_tags(a) == ("good", "new")
            await driver.until(lambda: "tags good, new" in driver.text("#details")
                               or "tags new" in driver.text("#details"))  # fmt: skip
            await driver.press("z")
            await driver.until(lambda: (read_tags(a), read_tags(b)) == (("good", "old"), ()))
            await driver.press("A", "T")
            await driver.at("Ask")
            await driver.press("ctrl+u")
            await driver.press("enter")
            await driver.until(lambda: () in (read_tags(a), read_tags(b)))


class TestNamesAndNotes:
    async def test_a_renamed_run_keeps_cursor_and_mark(self, walk, drive):
        for name in ("a", "b", "c"):
            walk(name, 0)
        async with drive() as driver:
            await driver.press("down")
            await driver.press("space", "up")
            table = driver.screen.query_one("#runs")
            old = table.run.name
            await driver.press("R")
            asked = await driver.at("Ask")
            box = asked.query_one(Input)
            box.value = "c" if old != "c" else "a"
            await driver.press("enter")
            assert "already exists" in driver.text("#ask-problem")
            box.value = "new name"
            await driver.press("enter")
            await driver.until(lambda: "new name" in names(driver))
            assert table.run.name == "new name"
            assert [path.name for path in table.marked] == ["new name"]
            assert sorted(path.name for path in Path("runs").iterdir()) == sorted(
                {"a", "b", "c"} - {old} | {"new name"}
            )
            await driver.press("z")
            await driver.until(lambda: old in names(driver))
            assert "new name of" in driver.notifications()

    @pytest.mark.slow
    async def test_a_note_is_written_shown_and_found(self, walk, drive):
        for name in ("a", "b"):
            walk(name, 0)
        async with drive() as driver:
            await driver.press("N")
            asked = await driver.at("AskText")
            await driver.type("drags one leg")
            await driver.press("escape")
            await driver.at("Confirm")
            await driver.press("n")
            await driver.until(lambda: driver.screen is asked)
            await driver.press("enter", "x", "ctrl+s")
            await driver.at("Home")
            run = driver.screen.query_one("#runs").run
            await driver.until(lambda: "drags one leg\nx" in driver.text("#details"))
            assert read_note(run.path) == "drags one leg\nx"
            await driver.press("down", "slash")
            await driver.type("leg")
            assert names(driver) == [run.name]


class TestBackground:
    @pytest.mark.slow
    async def test_a_background_run_shows_its_state_and_is_stopped_with_a_key(self, walk, drive):
        path = walk("b")
        walk("a")
        start_detached(path, paused=True)
        async with drive() as driver:
            await look(driver)
            await driver.until(lambda: "1 paused" in driver.screen.sub_title)
            table = driver.screen.query_one("#runs")
            await driver.press("up", *["down"] * names(driver).index("b"))
            assert table.run.name == "b"
            assert "‖ paused" in rows(driver)[table.cursor_row]
            assert not driver.offered() & {"home.delete", "home.rename"}
            await driver.press("x")
            await driver.until(lambda: "■ stopped" in rows(driver)[names(driver).index("b")])
            assert background_state(path) is None


class TestMouse:
    async def test_a_click_marks_highlights_or_opens(self, walk, drive):
        for name in ("a", "b"):
            walk(name, 0)
        async with drive() as driver:
            table = driver.screen.query_one("#runs")
            await driver.pilot.click("#runs", offset=(1, 2))
            assert (marks(driver), table.cursor_row) == ([False, True], 1)
            await driver.pilot.click("#runs", offset=(20, 1), control=True)
            assert (marks(driver), table.cursor_row) == ([True, True], 0)
            await driver.pilot.click("#runs", offset=(1, 2))
            assert marks(driver) == [True, False]
            await driver.pilot.click("#runs", offset=(8, 1))
            assert isinstance(driver.screen, Home)
            assert table.cursor_row == 0
            await driver.pilot.click("#runs", offset=(30, 1))
            await driver.at("Live")

    async def test_a_click_on_the_footer_acts(self, walk, drive):
        walk()
        async with drive() as driver:
            await driver.until(lambda: driver.screen.query(FooterKey))
            keys = {one.description: one for one in driver.screen.query(FooterKey)}
            await driver.pilot.click(keys.get("Help") or keys["More"])
            await driver.at("Help")


class TestNavigation:
    async def test_marked_runs_are_compared_or_replayed_side_by_side(self, walk, drive):
        walk("a")
        walk("b")
        async with drive() as driver:
            assert "home.compare" not in driver.offered()
            await driver.press("space", "space")
            assert marks(driver) == [True, True]
            assert "home.compare" in driver.offered()
            await driver.press("c")
            await driver.at("Compare")
            await driver.press("escape")
            await driver.at("Home")
            await driver.press("r")
            assert len((await driver.at("Replay")).panes) == 2


class TestPreview:
    async def test_the_champion_under_the_cursor_is_shown_after_a_rest(
        self, walk, drive, monkeypatch
    ):
        walk("a")
        walk("b")
        walk("empty", 0)
        reads, load = [], run_preview._load
        monkeypatch.setattr(run_preview, "_load", lambda run: reads.append(run.name) or load(run))
        async with drive(size=(110, 34)) as driver:
            home = driver.screen
            await driver.until(lambda: home.query("RunPreview"))
            preview = home.query_one("RunPreview")
            await driver.until(lambda: "no finished" in preview.canvas.placeholder())
            await driver.press("down")
            await driver.until(lambda: preview.canvas.skeleton is not None)
            assert home.current().name == "b"
            shown = str(preview.query_one(".figures").render())
            assert number(home.current().best, 4) in shown
            assert f"{home.current().evaluations} evaluations" in shown
            assert not preview.canvas.playing  # without animations
            await driver.press("down")
            await driver.until(lambda: reads == ["b", "a"])
            await driver.until(lambda: preview.canvas.skeleton is not None)
            await driver.press("up")
            await driver.until(lambda: preview.canvas.skeleton is not None)
            assert reads == ["b", "a"]

    async def test_it_moves_with_the_size_pauses_and_is_hidden_by_a_key(
        self, walk, drive, config, monkeypatch
    ):
        walk("a")
        settings = config("")
        async with drive(size=(150, 40), config=settings) as driver:
            home, app = driver.screen, driver.app
            app.animation_level = "full"
            await driver.until(lambda: home.query("RunPreview"))
            preview = home.query_one("RunPreview")
            await driver.until(lambda: preview.canvas.playing)
            table = home.query_one("#runs")
            assert preview.region.x == table.region.right
            app.app_focus = False
            await driver.until(lambda: not preview.canvas.playing)
            app.app_focus = True
            await driver.until(lambda: preview.canvas.playing)
            await driver.pilot.resize_terminal(110, 34)
            await driver.until(lambda: preview.region.y == table.region.bottom)
            await driver.pilot.resize_terminal(80, 24)
            await driver.until(lambda: not preview.display)
            assert "home.preview" not in driver.offered()
            await driver.pilot.resize_terminal(110, 34)
            await driver.until(lambda: preview.display)
            await driver.press("P")
            await driver.until(lambda: not preview.display)
            assert not preview.canvas.playing
        assert not read_config(settings.path).preview
