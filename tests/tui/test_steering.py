"""The steering screen: keys choose commands, and a flight ends on the ground."""

from functools import partial

import pytest
from kite import fly_kites

from gaitsim.errors import GaitsimError
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


async def open_steering(driver, load, clock):
    screen = Steering(load, "gaitsim steer", clock)
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


async def test_an_unreadable_controller_is_reported(kite, drive):
    def load():
        raise GaitsimError("there is no such run")

    async with drive() as driver:
        screen = Steering(load)
        driver.app.push_screen(screen)
        await driver.until(lambda: "no such run" in screen.body.placeholder())
        assert not {"steering.restart", "steering.pause"} & driver.offered()
        await driver.press("escape")
        await driver.at("Home")


@pytest.mark.slow
async def test_steering_opens_from_home_a_new_run_and_a_replay(kite, walk, drive, monkeypatch):
    run = walk()
    monkeypatch.setattr("gaitsim.steering.load_experiment", lambda _: kite)
    async with drive() as driver:

        def commands():
            return {one.title: one for one in driver.screen.palette()}

        commands()["Steer"].do()
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        assert screen.command_line() == "gaitsim steer"
        await driver.press("escape")
        driver.app.screen.show_screen("replay.Replay", run, 2)
        await driver.at("Replay")
        await driver.until(commands)
        assert {"Steer: stay", "Steer: rise", "Steer: sink"} <= {*commands()}
        commands()["Steer: rise"].do()
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        line = screen.command_line()
        assert line == f"gaitsim steer {run}/experiment.toml --controller rise={run}@2"
