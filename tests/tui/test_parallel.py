"""Parallel coordinates in the terminal: the members of a front, and the cells of a study."""

import pytest

from gaitsim.storage.snapshot import RunSnapshot

GOALS = 'search.objectives={ reach = "max", price = "max" }'
STUDY = """
name = "small"
experiments = ["millipede-mutation"]
set = { "evolution.generations" = 3 }
repeats = 2
[axes]
"evolution.population" = [5, 9]
"organism.pairs" = [2, 3]
"""


@pytest.mark.slow
async def test_members_of_a_front_are_selected_along_axes(walk, drive):
    run = walk("front", 4, "search.plugin=nsga-2", GOALS, "evolution.population=30", generations=9)
    members = RunSnapshot(run).members
    async with drive(size=(100, 30)) as driver:
        await driver.press("M")
        front = await driver.at("Front")
        await driver.until(lambda: front.pane.member is not None)
        front.pane.canvas.playing = False
        await driver.press("p")
        screen = await driver.at("Parallel")
        await driver.until(lambda: screen.plot.view is not None)
        plot = screen.plot
        assert plot.item + 1 == front.plot.member
        assert screen.command_line() == "gaitsim plot runs/front --kind parallel"
        await driver.press("left", "left", "up", "up", "up")
        ranked = members.values["reach"].argsort(kind="stable").tolist()
        start = ranked.index(front.plot.member - 1)
        assert plot.item == ranked[min(start + 3, len(ranked) - 1)]
        await driver.press("f", "greater_than_sign", "greater_than_sign")
        assert plot._order == [1, 2, 0]
        assert plot._flipped == {0}
        await driver.press("b")
        assert plot.item == plot.view.best
        await driver.pilot.click(plot, offset=(2, 3))
        await driver.pilot.pause()
        await driver.press("r")
        replay = await driver.at("Replay")
        await driver.until(lambda: replay.pane.shown is not None)
        assert replay.pane.which.number == plot.item + 1


@pytest.mark.slow
async def test_cells_of_a_study_are_shown(gaitsim, drive, tmp_path):
    (tmp_path / "small.toml").write_text(STUDY)
    gaitsim("study", "small.toml", "--workers", 1)
    assert (tmp_path / "studies/small/parallel.png").stat().st_size > 1000
    async with drive(size=(100, 30)) as driver:
        await driver.press("u")
        studies = await driver.at("Studies")
        await driver.until(lambda: studies._chosen() is not None)
        await driver.press("p")
        screen = await driver.at("Parallel")
        await driver.until(lambda: screen.plot.view is not None)
        assert [axis.name for axis in screen.plot.view.axes] == [
            *("evolution.population", "organism.pairs", "mean best score")
        ]
        assert "cell" in screen.query_one("Lines").text
        assert "parallel.replay" not in driver.offered()
        for cell in (tmp_path / "studies/small/cells").iterdir():
            cell.unlink()
        await driver.press("escape")
        await driver.at("Studies")
        screen = type(screen).of_study(tmp_path / "studies/small")
        driver.app.push_screen(screen)
        await driver.until(lambda: "no cell" in screen.plot.placeholder())
