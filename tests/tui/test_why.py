"""The screen that says why a champion scored."""

import pytest

import gaitsim as gs
from gaitsim.tui.screens.why import Why


def words(screen):
    """All that the screen says, as text."""
    console = screen.app.console
    with console.capture() as said:
        for part in screen.query("VerticalScroll > Static"):
            console.print(part._Static__content if hasattr(part, "_Static__content") else "")
    return said.get()


def test_it_says_which_terms_the_score_has_and_which_gait_it_is(walk, drive):
    run = walk()

    async def test(driver):
        await driver.press("w")
        screen = await driver.at("Why")
        await driver.until(lambda: len(screen.query("VerticalScroll > Static")) > 4)
        said = words(screen)
        for text in ("Why it scored", "reach", "price", "best of 1", "Gait: none", "speed"):
            assert text in said
        assert screen.command_line() == f"gaitsim analyse {run}"
        await driver.press("escape")
        driver.app.open_why(run, 2)
        await driver.until(lambda: "generation 2" in words(driver.screen))
        assert driver.screen.command_line() == f"gaitsim analyse {run} --generation 2"
        await driver.press("escape")
        driver.app.open_why(run, 9)
        await driver.until(lambda: "has no generation 9" in words(driver.screen))
        assert isinstance(driver.screen, Why)

    drive(test)


@pytest.mark.slow
def test_p_plays_the_gait_on_the_physical_twin_of_a_body_that_has_one(here, walk, drive):
    puppets = walk()
    with gs.evolve("spider", generations=1, population=4, out=here / "runs/eight") as search:
        list(search)

    async def test(driver):
        driver.app.open_why(puppets)
        await driver.until(lambda: "Gait: none" in words(driver.screen))
        assert not driver.screen.check_action("physics", ())
        await driver.press("escape")
        driver.app.open_why(here / "runs/eight")
        await driver.until(lambda: driver.screen.check_action("physics", ()))
        await driver.press("p")
        await driver.until(lambda: "of the forward distance" in words(driver.screen))
        assert driver.screen.command_line().endswith("--physics")
        assert not driver.screen.check_action("physics", ())

    drive(test)


def test_w_judges_the_gait_in_unseen_worlds(here, walk, drive, monkeypatch):
    monkeypatch.setattr("gaitsim.tui.screens.why.WORLDS", 12)
    puppets, short = walk(), {"organism.duration": 0.5}
    with gs.evolve("walker", generations=1, population=4, set=short, out=here / "runs/two") as run:
        list(run)

    async def test(driver):
        driver.app.open_why(puppets)
        await driver.until(lambda: "Gait: none" in words(driver.screen))
        assert not driver.screen.check_action("worlds", ())
        await driver.press("escape")
        driver.app.open_why(here / "runs/two")
        await driver.until(lambda: driver.screen.check_action("worlds", ()))
        await driver.press("w")
        await driver.until(lambda: "In 12 unseen worlds" in words(driver.screen))
        assert "worst tenth" in words(driver.screen)
        assert driver.screen.command_line().endswith("--worlds 12")
        assert not driver.screen.check_action("worlds", ())

    drive(test)
