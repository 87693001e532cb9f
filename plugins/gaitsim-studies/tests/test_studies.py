"""Studies, comparisons and verification in the app: start, follow, continue, read."""

import shutil
from pathlib import Path

import pytest
from textual.widgets import DataTable, Input

from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.form import Field
from gaitsim.tui.widgets.lists import OpenTable
from gaitsim_studies.results import StudyFolder

STUDY = """
name = "small"
description = "a [b]small[/] one \\u001b"
experiments = ["millipede-random"]
set = { "evolution.generations" = 3 }
repeats = 2
target = 1.0
[axes]
"evolution.population" = [5, 9]
"""


@pytest.fixture
def sweep(here):
    """Write the file of a study, small.toml."""
    Path("small.toml").write_text(STUDY)


def ended(driver):
    return bool(driver.app.tasks.all) and not any(task.running for task in driver.app.tasks.all)


def rows(driver):
    table = driver.screen.query_one(OpenTable)
    return [[str(cell) for cell in table.get_row_at(row)] for row in range(table.row_count)]


def displayed_texts(driver):
    """Return all texts of the results."""
    texts = [str(one.render()) for one in driver.screen.query(".heading, .paragraph")]
    tables = driver.screen.query(DataTable)
    cells = [table.get_row_at(row) for table in tables for row in range(table.row_count)]
    return "\n".join([*texts, *(str(cell) for row in cells for cell in row)])


async def write(driver, text):
    field = driver.screen.query(Input).first()
    field.value = text
    await driver.pilot.pause()


class TestStudies:
    @pytest.mark.slow
    async def test_a_study_is_started_followed_opened_and_continued_with_keys(self, sweep, drive):
        async with drive() as driver:
            await driver.press("u")
            screen = await driver.at("Studies")
            await driver.until(lambda: "no studies" in driver.text("#no-studies"))
            await driver.press("n")
            await driver.at("StudyDialog")
            await write(driver, "nosuch.toml")
            await driver.press("enter")
            await driver.until(lambda: "cannot read" in driver.text("#study-problem"))
            await write(driver, "small.toml")
            assert driver.text("#study-command") == "$ gaitsim study small.toml"
            await driver.press("enter")
            await driver.until(lambda: driver.screen is screen)
            await driver.until(lambda: ended(driver))
            await driver.until(lambda: rows(driver) and "finished" in rows(driver)[0][1])
            assert driver.app.tasks.all[0].state == "done"
            assert "a [b]small[/] one \\x1b" in driver.text("#study-about")
            assert screen.command_line() == "gaitsim study studies/small"
            assert "studies.continue" not in driver.offered()
            await driver.press("enter")
            results = await driver.at("StudyResults")
            await driver.until(lambda: "Cells" in displayed_texts(driver))
            assert "Cheapest population" in displayed_texts(driver)
            assert "±" in displayed_texts(driver)
            assert "surface-1-millipede-random.png" in displayed_texts(driver)
            assert results.command_line() == "gaitsim study studies/small"
            await driver.press("f", "down", "p")
            await driver.until(lambda: "Copied" in driver.notifications())
            await driver.press("v", "enter")
            tasks = await driver.at("TaskList")
            assert tasks.command_line() == "gaitsim verify studies/small"
            await driver.until(lambda: "identical" in driver.text("#task-text"))
            assert "2 of 2 cells run again" in driver.text("#task-text")
            await driver.press("escape", "escape")
            await driver.until(lambda: driver.screen is screen)
            assert screen.to_verify == Path("studies/small")
            next(Path("studies/small/cells").iterdir()).unlink()
            await driver.until(lambda: "stopped" in rows(driver)[0][1])
            assert "50 %" in rows(driver)[0][2]
            await driver.press("g")
            await driver.until(lambda: len(driver.app.tasks.all) == 3 and ended(driver))
            await driver.until(lambda: "finished" in rows(driver)[0][1])


@pytest.mark.slow
async def test_a_comparison_of_marked_runs_is_started_with_the_mouse(walk, drive):
    runs = [walk("one"), walk("two", 3, "seed=2")]
    async with drive() as driver:
        driver.app.screen.show_screen("compare.Compare", runs)
        await driver.at("Compare")
        await driver.until(lambda: "screen.statistics" in driver.offered())
        await driver.press("ctrl+s")
        await driver.at("StudyDialog")
        fields = driver.screen.query(Input)
        assert fields.first().value == "runs/one/experiment.toml runs/two/experiment.toml"
        fields[1].value = "2"
        targets = next(one for one in driver.screen.query(Field) if one.option.key == "targets")
        targets.query_one(Input).value = "1,x"
        await driver.until(lambda: "--targets 1,x" in driver.text("#study-command"))
        await driver.pilot.click("#begin")
        await driver.until(lambda: "invalid list of scores: " in driver.text("#study-problem"))
        targets.query_one(Input).value = "-9,99"
        await driver.until(lambda: "-9,99" in driver.text("#study-command"))
        # A button ignores a click while it is still drawn as pressed.
        await driver.until(lambda: not driver.screen.query_one("#begin").has_class("-active"))
        await driver.pilot.click("#begin")
        await driver.at("Studies")
        await driver.until(lambda: ended(driver))
        (task,) = driver.app.tasks.all
        assert task.state == "done", task.message
        await driver.until(lambda: rows(driver) and "finished" in rows(driver)[0][1])
        await driver.pilot.click(OpenTable, offset=(5, 1))
        await driver.at("StudyResults")
        await driver.until(lambda: "Methods" in displayed_texts(driver))
        assert "against" in displayed_texts(driver)
        assert "2 of 2" in displayed_texts(driver)


class TestVerify:
    @pytest.mark.slow
    async def test_a_run_is_verified_from_its_screen(self, walk, drive):
        run = walk()
        async with drive() as driver:
            await driver.press("v", "enter")
            screen = await driver.at("TaskList")
            await driver.until(lambda: ended(driver))
            await driver.until(lambda: "identical" in driver.text("#task-text"))
            assert "evolved again" in driver.text("#task-text")
            assert screen.command_line() == "gaitsim verify runs/walk"
            await driver.press("escape")
            shutil.copy("runs/walk/bests.bin", "bests.bin")
            data = bytearray(Path("bests.bin").read_bytes())
            data[8] ^= 1
            Path("runs/walk/bests.bin").write_bytes(data)
            await driver.press("v", "a")
            await driver.at("TaskList")
            await driver.until(lambda: "different" in driver.text("#task-text"))
            assert "$ gaitsim verify runs/walk --all" in driver.text("#task-text")
            driver.app.pop_screen()
            driver.app.screen.show_screen("live.Live", run)
            live = await driver.at("Live")
            await driver.until(lambda: live.to_verify == run)
            assert "screen.verify" in driver.offered()


def test_looks(here, snap_compare, monkeypatch):
    from gaitsim.tui.app import GaitsimApp

    found = [
        StudyFolder(Path("studies/rates"), "study", "running", 90, 195, "rates of mutation", 1e5),
        StudyFolder(Path("comparisons/a-against-b"), "comparison", "finished", changed=1e4),
        StudyFolder(Path("studies/old"), "study", "stopped", 3, 8, "", 1e3),
    ]
    monkeypatch.setattr("gaitsim_studies.studies_screen.list_folders", lambda: found)

    async def show(pilot):
        await pilot.press("u")
        await pilot.pause()
        await pilot.app.workers.wait_for_complete()
        await pilot.pause()

    app = GaitsimApp(Path("nowhere"), clock=lambda: 1e5 + 30)
    assert snap_compare(app, terminal_size=(80, 24), run_before=show)


async def test_the_footer_of_a_closed_screen_is_not_drawn_again(here, drive):
    async with drive() as driver:
        await driver.press("u")
        screen = await driver.at("Studies")
        closing = driver.app.pop_screen()
        await screen.query_one(DataTable).remove()  # its keys depend on it
        await screen.query_one(Footer).recompose()
        await closing
