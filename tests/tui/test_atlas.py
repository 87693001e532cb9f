"""The map of an archive: the cursor, the axes, and the elite beside it."""

from functools import partial

import numpy as np
import pytest
from textual.widgets import Input

from gaitsim.evaluation import evaluate
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

AXES = "search.axes={reach=[-1.0, 3.0], price=[-1.0, 0.0], score=[-2.0, 3.0]}"
ATLAS = ("search.plugin=map-elites", AXES, "search.cells=[12, 9, 3]", "evolution.population=40")


def evolve_one_generation(run):
    with RunWriter.open(run) as writer:
        next(iter(writer.evolve(partial(evaluate, writer.experiment))))


async def shown(driver, run):
    """Open the map of a run, with an elite beside it; pause the motion, which delays a pilot."""
    driver.app.screen.show_screen("atlas.Map", run)
    screen = await driver.at("Map")
    await driver.until(lambda: screen.pane.member is not None)
    screen.pane.canvas.playing = False
    return screen


@pytest.mark.slow
async def test_the_cursor_moves_between_elites_and_the_pane_shows_each(walk, drive):
    run = walk("atlas", 3, *ATLAS, generations=9)
    members = RunSnapshot(run).members
    best = int(np.argmax(members.scores)) + 1
    async with drive(size=(90, 30)) as driver:
        screen = await shown(driver, run)
        plan, pane = screen.plot, screen.pane
        assert plan.member == best
        assert f"member {best}" in screen.query_one("#member").text
        assert pane.member[0].individual.member.number == best
        assert f"{len(members.scores)} of 324 cells" in screen.sub_title
        assert "QD score" in screen.sub_title
        axes = plan.names
        assert screen.command_line().endswith(f"members runs/atlas --map --axes {' '.join(axes)}")

        # The cursor only rests on elites; the pane shows the elite under it.
        met = set()
        for key in ("left", "down", "left", "up", "right", "down", "left"):
            await driver.press(key)
            met.add(plan.member)
        assert len(met) > 2
        await driver.until(lambda: pane.member[0].individual.member.number == plan.member)
        assert pane.member[0].individual.score == members.scores[plan.member - 1]

        # The cursor stays on its gait along other axes, if it is the best of its cell there.
        await driver.press("b", "right_square_bracket")
        assert plan.names != axes
        assert plan.member == best
        await driver.press("z", "x", "left_square_bracket")
        assert plan.member == best

        await driver.press("g")
        await driver.until(lambda: driver.screen.query("#answer"))
        driver.screen.query_one(Input).value = str(len(members.scores) + 1)
        await driver.press("enter")
        assert "there is no member" in driver.text("#ask-problem")
        driver.screen.query_one(Input).value = "2"
        await driver.press("enter")
        await driver.until(lambda: driver.screen is screen)
        where = [members.values[name][1] for name in plan.names]
        cell = plan._picture.cell_of(*where)
        assert plan._picture.numbers[cell] == plan.member

        # A click on an empty cell moves to the nearest elite.
        await driver.pilot.click(plan, offset=(plan.size.width - 4, 2))
        await driver.pilot.pause()
        assert plan.member is not None


@pytest.mark.slow
async def test_the_map_updates_while_the_run_evolves_and_opens_the_replay(walk, drive, monkeypatch):
    monkeypatch.setattr("gaitsim.tui.screens.members.LOOK", 0.05)
    monkeypatch.setattr("gaitsim.tui.screens.members.SHARE", 1)
    run = walk("atlas", 3, *ATLAS, generations=9)
    walk("plain", 3)
    async with drive(size=(90, 30)) as driver:
        screen = await shown(driver, run)
        plan = screen.plot
        await driver.press("left", "down")

        # Members are added while another process evolves the run; the cursor stays.
        before, place = plan.view, plan._place
        evolve_one_generation(run)
        await driver.until(lambda: plan.view is not before)
        assert plan._place == place
        assert "generation 4" in screen.sub_title

        await driver.press("r")
        replay = await driver.at("Replay")
        await driver.until(lambda: replay.pane.shown is not None)
        assert replay.pane.which.number == plan.member
        assert "replay.map" in driver.offered()
        await driver.press("escape")
        await driver.at("Map")

        # A run without an archive shows an error.
        driver.app.screen.show_screen("atlas.Map", run.with_name("plain"))
        await driver.until(lambda: "keeps no archive" in driver.screen.plot.placeholder())
        assert "map.best" not in driver.offered()
        await driver.press("escape", "escape")
        driver.app.screen.show_screen("live.Live", run)
        await driver.at("Live")
        await driver.until(lambda: "live.map" in driver.offered())
