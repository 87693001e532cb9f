"""Features of every screen: help, palette, themes, keys and quitting."""

import asyncio
import os
import re
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest
from textual.binding import Binding
from textual.widgets import Input
from textual.worker import WorkerFailed

import gaitsim.tui
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.commands import Commands, escape_markup
from gaitsim.tui.keys import ACTIONS, NAMED, bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.home import Home
from gaitsim.tui.screens.questions import Confirm
from gaitsim.tui.widgets.footer import MORE, Item, fit_items


def all_subclasses(kind, *, leaves=True):
    for module in walk_packages(gaitsim.tui.__path__, "gaitsim.tui."):
        import_module(module.name)
    found, waiting = [], [kind]
    while waiting:
        known = waiting.pop().__subclasses__()
        waiting += known
        found += [one for one in known if one.__module__.startswith("gaitsim.tui")]
    return [one for one in found if not (leaves and one.__subclasses__())]


async def test_a_key_of_the_previous_screen_does_not_close_a_mounting_dialog(here, drive):
    async with drive() as driver:
        driver.app.push_screen(Confirm("Delete it?", "Delete"))
        assert not await driver.app.run_action("dismiss", driver.app.screen)
        await driver.until(lambda: driver.app.screen.query("#yes"))
        await driver.press("escape")
        await driver.at("Home")


class TestEveryScreen:
    @pytest.mark.parametrize("screen", all_subclasses(GaitScreen), ids=lambda kind: kind.__name__)
    def test_each_screen_has_a_help_and_keys_with_ids_and_tooltips(self, screen):
        assert len(screen.HELP_TEXT.strip()) > 80
        for binding in screen.BINDINGS:
            assert isinstance(binding, Binding)
            if binding.description:
                assert binding.id, binding
                assert binding.tooltip, binding

    def test_each_id_is_declared_once(self):
        ids = {}
        for kind in all_subclasses(import_module("textual.dom").DOMNode):
            for binding in kind.__dict__.get("BINDINGS", ()):
                if isinstance(binding, Binding) and binding.id:
                    assert ids.setdefault(binding.id, kind) is kind, binding.id

    def test_no_action_has_only_function_keys(self):
        for kind in all_subclasses(import_module("textual.dom").DOMNode):
            for binding in kind.__dict__.get("BINDINGS", ()):
                if isinstance(binding, Binding):
                    keys = binding.key.split(",")
                    assert not all(key[:1] == "f" and key[1:].isdigit() for key in keys), binding


def key(name, text, action=None):
    return Item(Binding(name, action or text.lower(), text, id=f"x.{name}"), name, text, True, "")


class TestFooter:
    @pytest.mark.parametrize("has_help", [True, False])
    def test_keys_are_complete_and_omitted_ones_are_announced(self, has_help):
        help_key = Item(
            Binding("question_mark", "help", "Help", id="app.help"), "?", "Help", True, ""
        )
        pair = [key("a", "Frame", "frame(-1)")._replace(text=""), key("b", "Frame", "frame(1)")]
        items = [key("c", "Open"), *pair, *(key(letter, "Something") for letter in "defg")]
        items += [help_key] * has_help
        palette = key("ctrl+p", "palette")
        for width in range(24, 130):
            shown = fit_items(items, palette, width)
            assert sum(item.width for item in shown) <= width
            assert shown[-1].binding is palette.binding
            omitted = len(shown) <= len(items)
            announced = [item.binding.action for item in shown if item.text == MORE]
            assert announced == ([] if not omitted else ["help" if has_help else "palette"])
            assert {item.key for item in shown} & {"a", "b"} in (set(), {"a", "b"})


class TestHelp:
    async def test_it_lists_the_available_keys_with_their_ids(self, walk, drive):
        walk()
        async with drive() as driver:
            await driver.press("question_mark")
            await driver.at("Help")
            rows = {row.name: row for row in driver.screen._rows}
            assert not rows["home.new"].reason
            assert "Mark two" in rows["home.compare"].reason
            assert rows["home.delete"].keys == ["d", "del"]
            assert rows["home.delete"].about == "Delete: move to the trash, after a question"
            assert rows["app.help"].about == "Help: show keys and their use"
            assert rows["home.mark"].about == "Mark the run, to act on several"
            await driver.press("escape")
            await driver.at("Home")

    @pytest.mark.slow
    async def test_every_action_acts_or_says_why_not(self, walk, drive):
        walk()
        async with drive() as driver:
            await driver.press("question_mark")
            names = [row.name for row in (await driver.at("Help"))._rows if row.reason]
            assert "home.compare" in names
            await driver.press("escape")
            for name in names:
                before = len(driver.app.notified)
                await self.select(driver, name)
                await driver.until(lambda before=before: len(driver.app.notified) > before)
                await driver.press("escape")
                await driver.at("Home")

    async def select(self, driver, action):
        await driver.press("question_mark")
        screen = await driver.at("Help")
        screen.query_one("#help-keys").highlighted = [row.name for row in screen._rows].index(
            action
        )
        await driver.press("enter")


class TestViKeys:
    @pytest.mark.slow
    async def test_they_move_in_tables_and_lists_but_not_in_fields(self, walk, drive, config):
        for name in "abcd":
            walk(name, 0)
        async with drive(config=config('[keys]\nlist.up = "m"')) as driver:
            table = driver.screen.query_one("#runs")
            places = []
            for key in ("j", "j", "m", "G", "g", "ctrl+d", "ctrl+u"):
                await driver.press(key)
                places.append(table.cursor_row)
            assert places == [1, 2, 1, 3, 0, 3, 0]
            assert {"list.down", "list.up"} <= driver.offered()
            await driver.press("slash")
            await driver.type("jkgGb")
            assert driver.screen.query_one("#filter", Input).value == "jkgGb"
            await driver.press("escape", "e")
            await driver.at("Home")  # no generation to export yet
            await driver.press("p")
            await driver.at("Plugins")
            menu = driver.screen.query_one("#installed")
            before = menu.highlighted
            await driver.press("j")
            assert menu.highlighted > before


class TestPalette:
    async def titles(self, driver):
        return [hit.text async for hit in Commands(driver.screen).discover()]

    async def test_it_lists_only_available_commands(self, walk, drive, here):
        async with drive() as driver:
            found = await self.titles(driver)
            assert {"New", "Plugins", "Help", "Quit", "New run: spider"} <= set(found)
            assert not {"Open", "Delete", "Compare", "Export", "Tasks"} & set(found)
            assert len(found) == len(set(found))
        walk()
        async with drive() as driver:
            assert {"Open", "Delete", "Export"} <= set(await self.titles(driver))

    async def test_a_command_is_found_and_run(self, here, drive):
        async with drive() as driver:
            await driver.press("ctrl+p")
            await driver.at("CommandPalette")
            await driver.type("plugins")
            await driver.pilot.pause(0.3)
            await driver.press("down", "enter")
            await driver.at("Plugins")

    async def found(self, driver, query):
        """Return the hits of a query by title, the best first."""
        hits = [hit async for hit in Commands(driver.screen).search(query)]
        return {hit.text: hit for hit in sorted(hits, key=lambda hit: -hit.score)}

    async def test_words_of_an_explanation_find_a_command(self, walk, drive):
        walk()
        async with drive() as driver:
            for query, title in (
                ("video", "Export"),
                ("gait file", "Export"),
                ("trash", "Trash"),
                ("any option", "Columns"),
                ("rename", "Rename"),
            ):
                assert next(iter(await self.found(driver, query)), query) == title
            assert not await self.found(driver, "zzz")

    async def test_unavailable_commands_have_reasons(self, walk, drive):
        walk("a")
        walk("b")
        async with drive() as driver:
            hit = (await self.found(driver, "compare"))["Compare"]
            assert "Mark two" in hit.help
            hit.command()
            assert "Mark two" in driver.notifications()
            await driver.press("space", "space")
            assert "Mark two" not in (await self.found(driver, "compare"))["Compare"].help
            await driver.press("enter")
            await driver.at("Live")
            await driver.until(lambda: driver.screen.snapshot.champion is not None)
            assert "is not evolving here" in (await self.found(driver, "pause"))["Pause"].help

    def test_all_actions_of_the_table_are_in_a_class(self):
        node = import_module("textual.dom").DOMNode
        known = all_subclasses(node, leaves=False)
        ids = {binding.id for kind in known for binding in kind.__dict__.get("BINDINGS", ())}
        groups = {(name or "").partition(".")[0] for name in ids}  # not those of packages
        assert {name for name in NAMED if name.partition(".")[0] in groups} <= ids
        assert len(NAMED) == sum(len(bindings(group)) for group in ACTIONS)

    @pytest.mark.parametrize("text", ["[b]x", "a[/b]", "[$error]z", "\\[x]", "[[", "]"])
    def test_titles_are_shown_literally(self, text):
        from textual.content import Content

        assert Content.from_markup(escape_markup(text)).plain == text


async def test_a_worker_ends_when_its_screen_is_closed(walk, drive):
    walk()
    async with drive() as driver:
        screen = GaitScreen()
        await driver.app.push_screen(screen)
        assert await screen.in_thread(int, "3") == 3
        await driver.app.pop_screen()
        with pytest.raises(asyncio.CancelledError):
            await screen.in_thread(int, "3")


class TestThemes:
    async def test_without_colours_all_is_grey(self, walk, drive, monkeypatch):
        monkeypatch.setenv("NO_COLOR", "1")
        walk()
        async with drive() as driver:
            svg = driver.app.export_screenshot()
            drawn = set(re.findall(r"-r\d+ \{ fill: #([0-9a-f]{6})", svg))
            coloured = {one for one in drawn if not one[:2] == one[2:4] == one[4:]}
            assert len(drawn) > 3
            assert coloured <= {"c5c8c6"}  # the default colour of the SVG
            assert "■" in svg


class TestKeys:
    async def test_a_key_of_the_settings_replaces_the_default(self, walk, drive, config):
        walk()
        async with drive(config=config('[keys]\nhome.delete = "ctrl+d"')) as driver:
            await driver.press("d")
            assert isinstance(driver.screen, Home)
            await driver.press("ctrl+d")
            await driver.at("Confirm")

    async def test_invalid_settings_are_reported_and_the_app_starts(self, here, drive, config):
        text = (
            '[tui]\ntheme = "gaitsim-lite"\n[keys]\nhome.delte = "x"\nhome.new = "ctl+d"\n[kyes]\n'
        )
        async with drive(config=config(text)) as driver:
            await driver.until(lambda: "home.delte" in driver.notifications())
            shown = driver.notifications()
            assert "unknown theme" in shown
            assert "did you mean 'gaitsim-light'?" in shown
            assert "did you mean 'home.delete'?" in shown
            assert 'there is no key "ctl+d"' in shown
            assert '• unknown key "kyes"; ' in shown
            assert driver.app.theme == "gaitsim-dark"


class TestEnding:
    async def test_a_screen_may_refuse_to_close(self, here, drive, monkeypatch):
        async def stay(screen):
            return False

        async with drive() as driver:
            await driver.press("p")
            screen = await driver.at("Plugins")
            monkeypatch.setattr(type(screen), "may_leave", stay)
            for key in ("escape", "q", "ctrl+q"):
                await driver.press(key)
                await driver.pilot.pause(0.05)
                assert driver.screen is screen
            monkeypatch.undo()
            await driver.press("escape")
            await driver.at("Home")


class TestImports:
    @pytest.mark.slow
    def test_home_imports_neither_compilers_nor_plotting(self, walk):
        walk()
        script = """
import asyncio, sys
from gaitsim.tui.app import GaitsimApp
assert "numpy" not in sys.modules, "before the first paint"
async def main():
    app = GaitsimApp()
    async with app.run_test() as pilot:
        while app.screen.runs is None:
            await pilot.pause(0.01)
        await pilot.pause()
        assert len(app.screen.query_one("#runs").shown) == 1
    print([name for name in ("numba", "matplotlib", "scipy", "typer", "av", "PIL", "aiohttp",
                             "gaitsim_puppets", "gaitsim_spider") if name in sys.modules])
asyncio.run(main())
"""
        done = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            env=os.environ,
            check=False,
        )
        assert (done.stdout, done.stderr) == ("[]\n", "")


async def fail(app, *, worker):
    async def fails():
        raise ZeroDivisionError

    async with app.run_test() as pilot:
        app.run_worker(fails()) if worker else app.call_later(fails)
        await pilot.pause()


@pytest.mark.parametrize("worker", [False, True])
async def test_an_unexpected_error_is_saved_and_reported(here, tmp_path, monkeypatch, worker):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    app = GaitsimApp(Path("runs"))
    with pytest.raises((ZeroDivisionError, WorkerFailed)):
        await fail(app, worker=worker)
    (file,) = tmp_path.glob("gaitsim-*.txt")
    assert "in fails" in file.read_text()
    assert "ZeroDivisionError" in file.read_text()
    assert app.return_code == 1
