"""The steering screen: keys choose commands, and a flight ends on the ground."""

from functools import partial

import pytest
from kite import fly_kites

from gaitsim.api import evolve, load
from gaitsim.steering import create_drive
from gaitsim.tui.screens.steering import Steering


class Clock:
    """A clock that a test advances."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def kite(here, puppet, puppets, monkeypatch):
    """Return the experiment of a kite."""
    fly_kites(monkeypatch, puppets.Puppet)
    return puppet()


async def open_steering(driver, load, clock, **options):
    screen = Steering(load, "gaitsim steer", clock, **options)
    driver.app.push_screen(screen)
    await driver.until(lambda: screen.drive is not None)
    return screen


async def fly(driver, screen, clock, seconds):
    """Advance the clock until a time is simulated or the flight has ended."""
    wanted = screen.drive.seconds + seconds
    clock.now += seconds
    await driver.until(lambda: screen.drive.ending or screen.drive.seconds >= wanted - 0.02)


async def test_keys_choose_commands_until_the_flight_ends(kite, drive):
    async with drive() as driver:
        clock = Clock()
        screen = await open_steering(driver, partial(create_drive, kite, {}), clock)
        assert screen.drive.command.name == "stay"
        await driver.press("up")
        assert screen.drive.command.name == "rise"
        await fly(driver, screen, clock, 0.5)
        assert screen.drive.altitude == pytest.approx(1.5, abs=0.03)
        for text in ("rise", "altitude", "flight time", "100 %"):
            assert text in driver.text("#steering-facts")
        await driver.press("left")  # no command has this key
        assert screen.drive.command.name == "rise"
        await driver.press("down")
        assert screen.drive.command.name == "stay"
        await driver.press("space")
        for _ in range(4):
            await fly(driver, screen, clock, 0.9)
        assert "hit the ground after" in driver.text("#steering-message")
        assert "steering.up" not in driver.offered()
        await driver.press("r")
        assert screen.drive.seconds < 0.1
        assert "holds until the next key" in driver.text("#steering-message")
        assert screen.command_line() == "gaitsim steer"
        await driver.press("escape")
        await driver.at("Home")


async def test_a_walking_body_is_driven_and_its_drive_saved(here, cart, drive):
    async with drive() as driver:
        clock = Clock()
        screen = await open_steering(driver, partial(create_drive, cart, {}), clock)
        assert "space" not in driver.text("#steering-message")
        assert "␣ is stop" in driver.text("#steering-message")
        assert not {"steering.save", "steering.a"} & driver.offered()
        await driver.press("left", "x")
        for _ in range(4):
            await driver.press("up")
        await fly(driver, screen, clock, 0.5)
        facts = driver.text("#steering-facts")
        for text in ("0.30 m/s", "0.5 rad/s", "↑ faster", "x push", "speed"):
            assert text in facts
        assert "altitude" not in facts
        assert "flight" not in facts
        assert "clipped to 0.3 m/s" in driver.text("#steering-message")
        assert screen.curve.series[0].name == "speed, m/s"
        await driver.press("down")
        await driver.until(lambda: "clipped" not in driver.text("#steering-message"))
        await driver.press("ctrl+s")
        await driver.until(lambda: screen.drive.saved is not None)
        assert load("cart-drive").champion.experiment.organism.drive
        assert "steering.save" not in driver.offered()
        await driver.press("escape")  # nothing to ask
        await driver.at("Home")


@pytest.mark.slow
async def test_leaving_and_restarting_ask_about_an_unsaved_drive(here, cart, drive):
    async with drive() as driver:
        clock = Clock()
        screen = await open_steering(driver, partial(create_drive, cart, {}), clock)
        await driver.press("up")
        for _ in range(4):
            await fly(driver, screen, clock, 0.9)
        await driver.press("escape")
        question = await driver.at("Choose")
        assert "Save the drive of 3.6 s as a run?" in str(question.query("Static").first().render())
        await driver.press("escape")
        assert driver.app.screen is screen
        await driver.press("r")
        await driver.at("Choose")
        await driver.press("d")
        await driver.until(lambda: screen.drive.seconds < 0.1)
        assert not (here / "runs").exists()
        await driver.press("up")
        for _ in range(8):
            if not screen.drive.ending:
                await fly(driver, screen, clock, 0.9)
        await driver.press("escape")
        await driver.at("Choose")
        await driver.press("s")
        await driver.at("Home")
        assert load("cart-drive").champion.experiment.organism.duration == pytest.approx(7.2)


@pytest.mark.slow
async def test_the_champion_of_a_run_is_steered_from_home_and_a_replay(here, cart, drive):
    for _ in evolve(cart, out="runs/cart"):
        pass
    async with drive() as driver:
        await driver.press("D")
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        assert screen.command_line() == "gaitsim steer runs/cart"
        await driver.press("escape")
        await driver.at("Home")
        await driver.press("r")
        await driver.at("Replay")
        await driver.until(lambda: driver.app.screen.pane.shown is not None)
        titles = {one.title for one in driver.app.screen.palette()}
        assert not [title for title in titles if title.startswith("Steer")]
        await driver.press("left_square_bracket", "D")
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        assert screen.command_line() == "gaitsim steer runs/cart@1"
