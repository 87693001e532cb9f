"""The front of a run as a scatter plot: the cursor, marks, axes, and the member beside it."""

import pytest
from textual.widgets import Input

from gaitsim.storage.snapshot import RunSnapshot

GOALS = 'search.objectives={ reach = "max", price = "max", score = "max" }'
FRONT = ("search.plugin=nsga-2", GOALS, "evolution.population=30")


@pytest.mark.slow
async def test_the_cursor_moves_along_the_front_and_two_members_are_compared(walk, drive):
    run = walk("front", 4, *FRONT, generations=9)
    members = RunSnapshot(run).members
    count = len(members.scores)
    assert count > 5
    async with drive(size=(110, 34)) as driver:
        await driver.press("M")
        screen = await driver.at("Front")
        plot, pane = screen.plot, screen.pane
        await driver.until(lambda: pane.member is not None)
        pane.canvas.playing = False
        assert plot.member == plot.view.best
        assert f"{count} members" in screen.sub_title
        assert screen.command_line().endswith("members runs/front --map --axes reach price")

        await driver.press("g")
        await driver.until(lambda: driver.screen.query("#answer"))
        driver.screen.query_one(Input).value = "1"
        await driver.press("enter")
        await driver.until(lambda: plot.member == 1)
        await driver.press("space", "full_stop", "full_stop", "space")
        assert (screen.marked, plot.member) == ([1, 3], 3)
        first, second = (f"{members.values['price'][at]:.4f}".replace("-", "−") for at in (0, 2))
        row = next(line for line in screen.query_one("#member").text.split("\n") if "price" in line)
        assert row.split()[1:4] == [second, first, second]
        await driver.until(lambda: pane.member[0].individual.member.number == 3)

        # The colour is the objective that is not on an axis.
        assert plot.colour == "score"
        await driver.press("x")
        assert (plot.names, plot.colour) == (("score", "price"), "reach")
        assert plot.member == 3
        await driver.press("o")
        assert not plot.others

        await driver.press("r")
        replay = await driver.at("Replay")
        await driver.until(lambda: all(pane.shown is not None for pane in replay.panes))
        assert [pane.which.number for pane in replay.panes] == [1, 3]
        await driver.press("escape")
        await driver.at("Front")

        await driver.pilot.click(plot, offset=(plot.size.width - 4, 2))
        await driver.pilot.pause()
        assert plot.member is not None
