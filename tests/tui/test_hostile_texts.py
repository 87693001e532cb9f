"""No text of a stranger reaches the terminal as a command or as markup, on any screen."""

import os

import pytest
from hostile_texts import CHANGES, ENTRIES, HOSTILE, MARKUP, NAME, PACKAGE, raw
from rich.segment import Segment
from textual.color import Color

from gaitsim.errors import GaitsimError
from gaitsim.tui.plain import PlainText


@pytest.fixture
def wicked(install, walk, monkeypatch):
    """A run whose folder, plugins, options, terms, measures and reasons hold hostile texts."""
    folder = install("wicked", PACKAGE, ENTRIES)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    return walk(NAME, 3, *CHANGES)


def shown(ui):
    """Everything on the screen, after checking that none of it steers the terminal."""
    rows = ui.screen._compositor.render_strips()
    text = "\n".join("".join(segment.text for segment in row) for row in rows)
    assert not raw(text)
    return text


async def shows(ui, text):
    await ui.until(lambda: text in shown(ui))


def test_texts_of_others_at_home_and_live(wicked, drive):
    async def test(ui):
        await shows(ui, MARKUP)
        await ui.press("d")
        await shows(ui, "\\u202e")
        await ui.press("n", "enter")
        live = await ui.at("Live")
        await shows(ui, "[bold]b")
        live.board.show_problem(GaitsimError(HOSTILE))
        await shows(ui, "\\u202e")

    drive(test, size=(180, 50))


@pytest.mark.slow
def test_texts_of_others_on_other_screens(wicked, drive):
    async def test(ui):
        home = ui.screen
        for open_it in (
            lambda: ui.app.open_replay(wicked),
            lambda: ui.app.open_compare([wicked, wicked]),
            lambda: ui.app.open_new(str(wicked / "experiment.toml")),
        ):
            open_it()
            await ui.until(lambda: ui.screen is not home)
            await shows(ui, "é")
            await ui.press("escape")
            await ui.at("Home")
        await ui.press("e")
        await shows(ui, "$ gaitsim export")
        await ui.press("escape", "enter")
        await ui.at("Live")
        for key in ("c", "f"):
            await ui.press(key)
            await shows(ui, "organism.length")
            await ui.press("escape")
        await ui.press("escape", "p")
        await ui.at("Plugins")
        await shows(ui, "wicked")
        task = ui.app.tasks.begin(["show", str(wicked)])
        await ui.press("t")
        await ui.until(lambda: not task.running)
        await shows(ui, "measure")

    drive(test, size=(180, 50))


def test_each_line_stays_as_wide():
    line = [Segment("a\x1b[1mb\u202e\udc80"), Segment("é"), Segment("\x9b\x07")]
    drawn = PlainText().apply(line, Color(0, 0, 0))
    assert [segment.text for segment in drawn] == ["a[1mb\ufffd", "é", ""]
    assert [segment.cell_length for segment in drawn] == [one.cell_length for one in line]
