"""No screen sends text from files to the terminal as control characters or markup."""

import os

import pytest
from hostile_texts import CHANGES, ENTRIES, HOSTILE, MARKUP, NAME, PACKAGE, raw
from rich.segment import Segment
from textual.color import Color

from gaitsim.errors import GaitsimError
from gaitsim.tui.terminal_output import ControlCharacterFilter


@pytest.fixture
def hostile_run(install, walk, monkeypatch):
    """Return a run with hostile texts in its folder, plugins, options, terms and reasons."""
    folder = install("wicked", PACKAGE, ENTRIES)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    return walk(NAME, 3, *CHANGES)


def screen_text(ui):
    """Return the text on the screen, after checking that it has no control characters."""
    rows = ui.screen._compositor.render_strips()
    text = "\n".join("".join(segment.text for segment in row) for row in rows)
    assert not raw(text)
    return text


async def wait_for_text(ui, text):
    await ui.until(lambda: text in screen_text(ui))


@pytest.mark.slow
async def test_hostile_texts_at_home_and_live(hostile_run, drive):
    async with drive(size=(180, 50)) as ui:
        await wait_for_text(ui, MARKUP)
        await ui.press("d")
        await wait_for_text(ui, "\\u202e")
        await ui.press("n", "enter")
        live = await ui.at("Live")
        await wait_for_text(ui, "[bold]b")
        live.board.show_problem(GaitsimError(HOSTILE))
        await wait_for_text(ui, "\\u202e")


def test_removing_control_characters_keeps_the_width():
    line = [Segment("a\x1b[1mb\u202e\udc80"), Segment("é"), Segment("\x9b\x07")]
    drawn = ControlCharacterFilter().apply(line, Color(0, 0, 0))
    assert [segment.text for segment in drawn] == ["a[1mb\ufffd", "é", ""]
    assert [segment.cell_length for segment in drawn] == [one.cell_length for one in line]
