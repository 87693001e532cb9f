"""Challenge codes and the gallery in the terminal UI."""

from dataclasses import replace

import pytest

from gaitsim.sharing.challenge import Challenge


async def test_a_code_is_copied_from_the_replay(walk, drive):
    run = walk()
    async with drive() as driver:
        driver.app.screen.show_screen("replay.Replay", run)
        screen = await driver.at("Replay")
        await driver.until(lambda: screen.pane.shown is not None)
        await driver.press("C")
        await driver.at("AskText")
        found = Challenge.read(driver.app.clipboard)
        shown = screen.pane.shown
        assert found.score == shown.individual.score
        assert driver.screen.query_one("#text").text == driver.app.clipboard
        await driver.press("escape")
        await driver.at("Replay")


@pytest.mark.slow
async def test_a_pasted_code_is_verified(walk, drive):
    run = walk()
    async with drive() as driver:
        from gaitsim.api import load

        code = load(run).share()
        forged = replace(Challenge.read(code), score=99.0).code
        for pasted, verdict in (
            (f"{code[:30]}\n {code[30:]}", ": reproduced"),
            (forged, ": not reproduced"),
        ):
            driver.app.screen.verify_code()
            await driver.at("AskText")
            driver.screen.query_one("#text").text = pasted
            await driver.press("ctrl+s")
            await driver.at("TaskList")
            await driver.until(lambda: not driver.app.tasks.all[-1].running)
            await driver.until(lambda verdict=verdict: verdict in driver.text("#task-text"))
            assert "Running" not in driver.notifications()
            assert "Done" not in driver.notifications()
            await driver.press("escape")


@pytest.mark.packages
async def test_home_writes_a_gallery(walk, drive, monkeypatch):
    walk()
    async with drive() as driver:
        started = []
        monkeypatch.setattr(driver.app, "start_task", lambda words, **_: started.append(words))
        await driver.press("B")
        await driver.at("Ask")
        await driver.press("enter")
        await driver.until(lambda: bool(started))
        assert started == [("gallery", "runs", "--out", "site")]
