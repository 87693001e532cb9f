"""Text is readable in every theme, on every screen, also after a switch of the theme."""

import re

import pytest
from hypothesis import given, strategies as st
from textual.command import CommandList

from gaitsim.tui.screens.base import Dialog
from gaitsim.tui.terminal_output import raise_contrast

DRAWING = re.compile(r"[\s\u2500-\u259f\u2800-\u28ff]*")
SCREENS = {
    "Home": [],
    "Live": ["enter"],
    "Replay": ["r"],
    "Why": ["w"],
    "Plugins": ["p"],
    "New": ["n", "enter"],
    "Presets": ["n"],
    "ExportDialog": ["e"],
    "AskText": ["N"],
    "ChangeForm": ["enter", "c"],
    "Compare": ["space", "down", "space", "c"],
    "Studies": ["u"],
    "Help": ["question_mark"],
}


def luminance(colour):
    parts = [part / 255 for part in colour]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    """The contrast ratio of two colours (WCAG 2.1)."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def texts(screen):
    """Yield the visible texts with their styles; those in a dialog only, if it is one."""
    region = screen.query(".dialog").first().region if isinstance(screen, Dialog) else screen.region
    for y, strip in enumerate(screen._compositor.render_strips()):
        if region.y <= y < region.bottom:
            for segment in strip.crop(region.x, region.right):
                if not DRAWING.fullmatch(segment.text):
                    yield segment.text, segment.style


def unreadable(screen):
    return [
        (text, str(style))
        for text, style in texts(screen)
        if style.dim or contrast(style.color.triplet, style.bgcolor.triplet) < 4.5
    ]


@pytest.mark.slow
@pytest.mark.parametrize("screen", SCREENS)
async def test_themes_are_readable_on_every_screen(walk, drive, screen):
    """Check gaitsim's own themes on each screen, and every other theme on at least three."""
    walk("one", 3)
    walk("two", 4)
    async with drive(size=(110, 34)) as driver:
        await driver.press(*SCREENS[screen])
        shown = await driver.at(screen)
        if screen == "New":
            await driver.until(lambda: shown.validation is not None)
        themes = sorted(
            theme for theme in driver.app.available_themes if not theme.startswith("ansi")
        )
        own = [theme for theme in themes if theme.startswith("gaitsim")]
        for theme in {*own, *themes[[*SCREENS].index(screen) % 4 :: 4]}:
            driver.app.theme = theme
            await driver.pilot.pause()
            await driver.pilot.pause()
            assert len([*texts(shown)]) >= 4
            assert unreadable(shown) == [], theme


@pytest.mark.slow
async def test_a_switch_recolours_lists_on_all_screens(walk, drive):
    walk("one", 3)
    async with drive(size=(110, 34)) as driver:
        home = driver.screen
        colour = {}
        for theme in ("gaitsim-light", "gaitsim-dark"):
            await driver.press("p")  # home is below
            plugins = await driver.at("Plugins")
            driver.app.theme = theme
            await driver.pilot.pause()
            await driver.pilot.pause()
            assert unreadable(plugins) == []
            heading = next(style for text, style in texts(plugins) if text.strip() == "bodies")
            await driver.press("escape")
            await driver.until(lambda: driver.screen is home)
            await driver.pilot.pause()
            assert unreadable(home) == []
            state = next(
                style for text, style in texts(home) if "finished" in text or "stopped" in text
            )
            colour[theme] = heading.color.name, state.color.name
        assert not {*colour["gaitsim-light"]} & {*colour["gaitsim-dark"]}


colours = st.tuples(*[st.integers(0, 255)] * 3)


@given(colours, colours)
def test_a_raised_contrast_is_enough(colour, ground):
    raised = raise_contrast(colour, ground)
    assert contrast(raised, ground) >= 4.5
    if contrast(colour, ground) >= 4.5:
        assert raised == colour


@pytest.mark.slow
async def test_the_palette_of_a_dialog_acts_in_the_dialog(walk, drive):
    walk("one", 3)
    async with drive() as driver:
        await driver.press("e")
        dialog = await driver.at("ExportDialog")
        await driver.press("ctrl+p")
        palette = await driver.at("CommandPalette")
        await driver.type("fitness curve")
        menu = palette.query_one(CommandList)
        await driver.until(lambda: menu.option_count == 1)
        await driver.press("enter")
        await driver.until(lambda: driver.screen is dialog)
        await driver.until(lambda: dialog._product.title == "Fitness curve")
