"""The steering screen: keys choose commands, and a flight ends on the ground."""

from functools import partial

import pytest
from kite import fly_kites

from gaitsim.errors import GaitsimError
from gaitsim.steering import drive_with
from gaitsim.tui.screens.steering import Steering


class Clock:
    """Seconds that a test lets pass."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def kite(here, puppet, puppets, monkeypatch):
    """The experiment of a kite."""
    fly_kites(monkeypatch, puppets.Puppet)
    return puppet()


async def begun(driver, load, clock):
    screen = Steering(load, "gaitsim steer", clock)
    driver.app.push_screen(screen)
    await driver.until(lambda: screen.drive is not None)
    return screen


async def fly(driver, screen, clock, seconds):
    """Let time pass until it is simulated, or the flight has ended."""
    wanted = screen.drive.seconds + seconds
    clock.now += seconds
    await driver.until(lambda: screen.drive.ending or screen.drive.seconds >= wanted - 0.02)


def test_keys_choose_the_command_until_the_ground_ends_the_flight(kite, drive):
    async def test(driver):
        clock = Clock()
        screen = await begun(driver, partial(drive_with, kite, {}), clock)
        assert screen.drive.command.name == "stay"
        await driver.press("up")
        assert screen.drive.command.name == "rise"
        await fly(driver, screen, clock, 0.5)
        assert screen.drive.altitude == pytest.approx(1.5, abs=0.03)
        for said in ("rise", "altitude", "in the air", "100 %"):
            assert said in driver.text("#steering-facts")
        await driver.press("left")  # no command has this key
        assert screen.drive.command.name == "rise"
        await driver.press("down")
        assert screen.drive.command.name == "stay"
        await driver.press("space")
        for _ in range(4):
            await fly(driver, screen, clock, 0.9)
        assert "hit the ground after" in driver.text("#steering-said")
        assert "steering.up" not in driver.offered()
        await driver.press("r")
        assert screen.drive.seconds < 0.1
        assert "holds until the next key" in driver.text("#steering-said")
        assert screen.command_line() == "gaitsim steer"
        await driver.press("escape")
        await driver.at("Home")

    drive(test)


def test_p_pauses_h_helps_and_v_changes_the_view_at_any_size(kite, drive):
    async def test(driver):
        clock = Clock()
        screen = await begun(driver, partial(drive_with, kite, {}), clock)
        await driver.press("p")
        seconds = screen.drive.seconds
        clock.now += 0.5
        await driver.pilot.pause(0.15)
        assert screen.drive.seconds == seconds
        assert "Paused" in driver.text("#steering-said")
        await driver.press("p")
        await fly(driver, screen, clock, 0.2)
        view = screen.body.chosen
        await driver.press("v", "plus")
        assert screen.body.chosen != view
        assert screen.body.zoom > 1
        await driver.press("h")
        await driver.at("Help")

    drive(test)
    drive(test, size=(160, 48))


def test_a_controller_that_cannot_be_read_shows_why(kite, drive):
    def load():
        raise GaitsimError("there is no such run")

    async def test(driver):
        screen = Steering(load)
        driver.app.push_screen(screen)
        await driver.until(lambda: "no such run" in screen.body.words())
        assert not {"steering.restart", "steering.pause"} & driver.offered()
        await driver.press("escape")
        await driver.at("Home")

    drive(test)


def test_it_is_reached_from_home_a_new_run_and_a_replay(kite, walk, drive, monkeypatch):
    run = walk()
    monkeypatch.setattr("gaitsim.steering.load_experiment", lambda _: kite)

    async def test(driver):
        def commands():
            return {one.title: one for one in driver.screen.palette()}

        commands()["Steer"].do()
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        assert screen.command_line() == "gaitsim steer"
        await driver.press("escape")
        driver.app.open_replay(run, 2)
        await driver.at("Replay")
        await driver.until(commands)
        assert {"Steer: stay", "Steer: rise", "Steer: sink"} <= {*commands()}
        commands()["Steer: rise"].do()
        screen = await driver.at("Steering")
        await driver.until(lambda: screen.drive is not None)
        line = screen.command_line()
        assert line == f"gaitsim steer {run}/experiment.toml --controller rise={run}@2"

    drive(test)
