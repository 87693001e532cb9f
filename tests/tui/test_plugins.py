"""The screen of installed plugins."""

from contextlib import asynccontextmanager

import pytest
from rich.console import Console
from rich.theme import Theme

from gaitsim.registry import EXPERIMENTS, PLUGINS, entries, options
from gaitsim.tui.catalogue import read_catalogue
from gaitsim.tui.screens.plugins import plugin_view
from gaitsim.tui.themes import INKS, ink_styles

THEME = Theme(ink_styles(dict.fromkeys(INKS, "#00ff00")))


def shown(driver):
    """Return the text on the right side."""
    console = Console(width=400, color_system=None, theme=THEME)
    with console.capture() as capture:
        console.print(driver.screen.query_one("#about-plugin").content)
    return capture.get()


def keys(driver):
    menu = driver.screen.query_one("#installed")
    return [option.id for option in menu.options if option.id]


async def go(driver, key):
    menu = driver.screen.query_one("#installed")
    menu.highlighted = menu.get_option_index(key)
    await driver.pilot.pause()


@pytest.fixture
def look(here, drive):
    """Return a context that opens the screen."""

    @asynccontextmanager
    async def look(**options):
        async with drive(**options) as driver:
            driver.app.screen.show_screen("plugins.Plugins")
            screen = await driver.at("Plugins")
            await driver.until(lambda: screen.catalogue is not None)
            yield driver

    return look


@pytest.mark.parametrize("size", [(80, 24), pytest.param((160, 48), marks=pytest.mark.slow)])
async def test_all_plugins_are_listed_with_their_packages(look, size):
    async with look(size=size) as driver:
        kinds = (*PLUGINS, EXPERIMENTS)
        assert keys(driver) == [f"{k} {n}" for k in kinds for n in entries(k)]
        for key in keys(driver)[:: len(keys(driver)) // 3]:
            kind, _, name = key.partition(" ")
            await go(driver, key)
            text = shown(driver)
            for claim in entries(kind)[name]:
                assert claim.source in text
                assert claim.target in text


async def test_options_are_described_in_full(look):
    async with look() as driver:
        await go(driver, "fitness puppet-reach")
        text, field = shown(driver), driver.screen.catalogue.classes["fitness"]["puppet-reach"]
        price = field.model_fields["price"]
        for part in ("price", options.default(price), options.allowed(price), price.description):
            assert part in text
        assert "works with  bit-puppet, puppet" in text
        assert "joint_angles, reach" in text


@pytest.mark.parametrize("width", [46, 84, 150])
def test_no_width_breaks_a_word(width, puppets):
    catalogue = read_catalogue()
    for kind, classes in catalogue.classes.items():
        for name, plugin in classes.items():
            console = Console(width=width, color_system=None, theme=THEME)
            with console.capture() as capture:
                console.print(plugin_view(kind, name, catalogue))
            words = {*capture.get().replace("=", " ").split()}
            for option, field in plugin.model_fields.items():
                cells = option, options.default(field), options.meaning(field)
                described = " ".join([*cells, options.allowed(field)]).replace("=", " ")
                assert {*described.split()} <= words, (name, cells)


@pytest.mark.slow
async def test_the_list_is_filtered_by_words(look):
    async with look() as driver:
        everything = keys(driver)
        await go(driver, "mutation gaussian")
        await driver.press("slash")
        await driver.type("price reach")  # of an option, and of a name
        assert keys(driver) == ["fitness puppet-reach"]
        assert "price" in shown(driver)
        await driver.press("enter", "y")
        assert driver.app.clipboard == "gaitsim plugins show puppet-reach"
        await driver.press("slash", "x", "x")
        assert keys(driver) == []
        assert "No plugin matches all these words" in str(
            driver.screen.query_one("#installed").get_option_at_index(0).prompt
        )
        assert driver.screen.command_line() == "gaitsim plugins list"
        await driver.press("escape")
        assert keys(driver) == everything
        assert driver.app.focused.id == "installed"


async def test_broken_plugins_are_marked_with_the_reason(look, install):
    install("broken", "raise RuntimeError('no [b]luck')", {"fitness": {"ba[d]": "Bad"}})
    install("one", "", {"mutation": {"twice": "A"}})
    install("two", "", {"mutation": {"twice": "B"}})
    async with look() as driver:
        menu = driver.screen.query_one("#installed")
        assert "✗ ba[d]" in str(menu.get_option("fitness ba[d]").prompt)
        await go(driver, "fitness ba[d]")
        assert "no [b]luck" in shown(driver)
        await go(driver, "mutation twice")
        text = shown(driver)
        assert "registered more than once" in text
        assert "one 1.0" in text
        assert "two 1.0" in text


@pytest.mark.packages
async def test_a_check_runs_in_the_background(look, monkeypatch):
    async with look() as driver:
        started = []
        monkeypatch.setattr(
            type(driver.app), "start_task", lambda app, words: started.append(words)
        )
        await go(driver, "mutation gaussian")
        await driver.press("ctrl+k")
        assert started == [("plugins", "check", "gaussian")]
