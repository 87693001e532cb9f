"""The screen that explains the score of an individual."""

from dataclasses import replace

import pytest

import gaitsim as gs
from gaitsim.gait import analyse_individual
from gaitsim.gait.worlds import FeedbackResults, Outcome, WorldResults
from gaitsim.tui.screens.why import Why


def displayed_texts(screen):
    """Return the text of the screen."""
    console = screen.app.console
    with console.capture() as capture:
        for part in screen.query("VerticalScroll > Static"):
            console.print(part._Static__content if hasattr(part, "_Static__content") else "")
    return capture.get()


async def test_the_screen_lists_the_terms_and_names_the_gait(walk, drive, monkeypatch):
    def analyse(individual):
        return replace(analyse_individual(individual), warnings=("The gait chatters",))

    monkeypatch.setattr("gaitsim.tui.screens.why.analyse_individual", analyse)
    run = walk()
    async with drive() as driver:
        await driver.press("w")
        screen = await driver.at("Why")
        await driver.until(lambda: len(screen.query("VerticalScroll > Static")) > 4)
        texts = displayed_texts(screen)
        for text in (
            "Score analysis",
            "reach",
            "price",
            "best of 1",
            "Gait: none",
            "speed",
            "chatters",
        ):
            assert text in texts
        assert screen.command_line() == f"gaitsim analyse {run}"
        await driver.press("escape")
        driver.app.screen.show_screen("why.Why", run, 2)
        await driver.until(lambda: "generation 2" in displayed_texts(driver.screen))
        assert driver.screen.command_line() == f"gaitsim analyse {run} --generation 2"
        await driver.press("escape")
        driver.app.screen.show_screen("why.Why", run, 9)
        await driver.until(lambda: "has no generation 9" in displayed_texts(driver.screen))
        assert isinstance(driver.screen, Why)


async def test_the_screen_shows_whether_the_gait_holds(walk, drive, puppets, monkeypatch):
    windy = walk("windy", 1, "organism.plugin=windy-puppet")
    async with drive() as driver:
        driver.app.screen.show_screen("why.Why", windy)
        await driver.until(lambda: "Does not hold" in displayed_texts(driver.screen))
        await driver.press("escape")
        monkeypatch.setattr(puppets.WindyPuppet, "checks", lambda body: [{"fog": 1.0}])
        driver.app.screen.show_screen("why.Why", windy)
        await driver.until(lambda: "names an invalid check" in displayed_texts(driver.screen))


async def test_the_screen_shows_what_reflexes_are_worth(walk, drive, monkeypatch):
    course = Outcome(2.0, 0.0, fell=False, yaw=0.1)
    results = FeedbackResults(
        ("heading",), *[WorldResults("forward", "m", course, ({},), (course,))] * 2
    )
    monkeypatch.setattr("gaitsim.tui.screens.why.compare_blind", lambda one, workers: results)
    run = walk()
    async with drive() as driver:
        driver.app.screen.show_screen("why.Why", run)
        await driver.until(lambda: "Reflexes: heading." in displayed_texts(driver.screen))
        assert "with reflexes" in displayed_texts(driver.screen)


@pytest.mark.slow
async def test_w_evaluates_the_gait_in_unseen_worlds(here, walk, drive, monkeypatch):
    monkeypatch.setattr("gaitsim.tui.screens.why.WORLDS", 12)
    puppets, short = walk(), {"organism.duration": 0.5}
    with gs.evolve("walker", generations=1, population=4, set=short, out=here / "runs/two") as run:
        list(run)
    async with drive() as driver:
        driver.app.screen.show_screen("why.Why", puppets)
        await driver.until(lambda: "Gait: none" in displayed_texts(driver.screen))
        assert not driver.screen.check_action("worlds", ())
        await driver.press("escape")
        driver.app.screen.show_screen("why.Why", here / "runs/two")
        await driver.until(lambda: driver.screen.check_action("worlds", ()))
        await driver.press("w")
        await driver.until(lambda: "In 12 unseen worlds" in displayed_texts(driver.screen))
        assert "worst tenth" in displayed_texts(driver.screen)
        assert driver.screen.command_line().endswith("--worlds 12")
        assert not driver.screen.check_action("worlds", ())
