"""Attacked run folders in the terminal UI: every screen opens or shows an error, and closes."""

import shutil
import sys

import pytest
from hostile import CASES, attacked, make_template

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs pipes, links")

ASKING = {"ask", "fork", "default"}  # workers that wait for a dialog


async def visit(drive, runs):
    """Open the attacked run in every screen, press keys there, and leave it."""
    victim, other = runs / "victim", runs / "other"

    async with drive(folder=runs) as driver:
        app, home = driver.app, driver.screen

        async def settled():
            await driver.pilot.pause()
            await driver.until(lambda: all(one.group in ASKING for one in app.workers))

        async def left(screen):
            await driver.press("escape")
            await driver.until(lambda: driver.screen is screen)

        for open_screen, pressed in (
            (lambda: app.screen.show_screen("live.Live", victim, resume=True), "recfg"),
            (lambda: app.screen.show_screen("replay.Replay", victim), "be"),
            (lambda: app.screen.show_screen("replay.Replay", other, None, victim), "b"),
            (lambda: app.screen.show_screen("compare.Compare", [other, victim]), "x"),
        ):
            open_screen()
            await driver.until(lambda: driver.screen is not home)
            await settled()
            opened = driver.screen
            for key in pressed:
                await driver.press(key)
                await settled()
                if driver.screen is not opened:
                    await left(opened)
            await left(home)


@pytest.mark.slow
async def test_attacked_runs(here, gaitsim, drive, tmp_path, monkeypatch):
    make_template(gaitsim)
    for number, (file, attack) in enumerate([("exports", "link to a folder"), *CASES[::67]]):
        folder = tmp_path / str(number)
        attacked(here, folder, file, attack)
        monkeypatch.chdir(folder)
        try:
            await visit(drive, folder / "runs")
        except BaseException as error:
            error.add_note(f"{file}: {attack}")
            raise
        monkeypatch.chdir(tmp_path)
        shutil.rmtree(folder)
