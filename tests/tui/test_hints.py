"""Hints about keys, which leave once the keys are known."""

import json

import pytest

from gaitsim.tui.config import read_config
from gaitsim.tui.hints import HINTED, LEARNT, Hints, state_path
from gaitsim.tui.keys import NAMED
from gaitsim.tui.widgets.footer import HintLine


@pytest.fixture
def config(tmp_path):
    """Return a function that writes and reads a config file."""

    def config(text=""):
        path = tmp_path / "config.toml"
        path.write_text(text)
        return read_config(path)

    return config


def test_every_hint_is_of_an_action():
    assert {*HINTED} <= {*NAMED}


@pytest.mark.slow
async def test_a_hint_leaves_once_its_key_was_used(walk, drive, config):
    walk()
    async with drive(config=config()) as driver:
        await driver.until(lambda: "create a new run" in driver.text(HintLine))
        assert "n: create a new run" in driver.text(HintLine)
        for _ in range(LEARNT):
            await driver.press("n")
            await driver.at("Presets")
            await driver.press("escape")
            await driver.at("Home")
        await driver.until(lambda: "create a new run" not in driver.text(HintLine))
        await driver.until(lambda: state_path().exists())
        await driver.until(lambda: json.loads(state_path().read_text())["home.new"] == LEARNT)
    async with drive(config=config()) as driver:
        await driver.until(lambda: "watch or continue" in driver.text(HintLine))
        assert "create a new run" not in driver.text(HintLine)


async def test_a_hint_shows_the_key_of_the_settings(walk, drive, config):
    walk()
    async with drive(config=config('[keys]\nhome.new = "ctrl+n"')) as driver:
        await driver.until(lambda: "^n: create a new run" in driver.text(HintLine))


async def test_a_hint_that_does_not_fit_is_omitted(walk, drive, config):
    walk()
    async with drive(config=config(), size=(80, 24)) as driver:
        await driver.press("r")
        await driver.at("Replay")
        await driver.until(lambda: "pause the motion" in driver.text(HintLine))
        assert driver.text(HintLine) == "Hint: space: pause the motion"
        await driver.pilot.resize_terminal(120, 34)
        await driver.until(lambda: "above, or the front" in driver.text(HintLine))


async def test_hints_can_be_turned_off(walk, drive, config):
    walk()
    async with drive(config=config("[tui]\nhints = false")) as driver:
        assert not driver.screen.query(HintLine)


def test_only_true_and_false_are_valid(config):
    given = config('[tui]\nhints = "no"')
    assert given.hints
    assert "allowed: true or false" in str(given.problems[0])


@pytest.mark.parametrize("content", ["", "[1]", "null", '{"home.new": "x"}', "[" * 100_000, "\0"])
def test_a_damaged_file_is_ignored(tmp_path, content):
    path = tmp_path / "keys.json"
    path.write_text(content)
    hints = Hints(path)
    assert hints.is_needed("home.new")
    assert hints.count("home.new")
    hints.save()
    assert json.loads(path.read_text()) == {"home.new": 1}


def test_a_folder_that_cannot_be_written_is_ignored(tmp_path):
    (tmp_path / "file").write_text("")
    hints = Hints(tmp_path / "file" / "keys.json")
    hints.count("home.new")
    hints.save()
