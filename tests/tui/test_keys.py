"""Bursts of keys: what is typed while a dialog opens or closes reaches the dialog."""

import pytest
from textual.events import Key
from textual.widgets import Input, TextArea

BURST = "nRpSds/xqcf"  # letters that have a meaning on the screens below


def send(app, *keys):
    """Send keys at once, as a fast typist does."""
    for key in keys:
        app.post_message(Key({"/": "slash"}.get(key, key), key if len(key) == 1 else None))


def text_of(screen):
    field = screen.app.focused
    assert isinstance(field, Input | TextArea)
    return field.text if isinstance(field, TextArea) else field.value


@pytest.fixture
def two(walk):
    walk("one", 3)
    walk("two", 4)


@pytest.mark.parametrize(
    ("opening", "dialog"),
    [
        (["R"], "Ask"),  # rename
        (["B"], "Ask"),  # gallery
        (["N"], "NoteDialog"),
        (["enter", "c"], "ChangeDialog"),
        (["enter", "f"], "ChangeDialog"),  # fork
        (["enter", "g"], "Ask"),  # generations
        (["slash"], "Home"),  # the filter
    ],
)
async def test_a_field_receives_all_keys_typed_while_it_opens(two, drive, opening, dialog):
    async with drive() as driver:
        home = driver.screen
        shown = [run.name for run in home.query_one("#runs").shown]
        send(driver.app, *opening, *BURST)
        await driver.until(lambda: type(driver.screen).__name__ == dialog)
        await driver.until(lambda: text_of(driver.screen).endswith(BURST))
        send(driver.app, *["backspace"] * len(BURST))
        await driver.until(lambda: BURST[0] not in text_of(driver.screen)[-1:])
        if dialog != "Home":
            send(driver.app, *["escape"] * (len(opening) + (dialog == "NoteDialog")), "j", "j")
            await driver.until(lambda: driver.screen is home)
        assert [run.name for run in home.query_one("#runs").shown] == shown


async def test_keys_after_a_dialog_closes_act_below(two, drive):
    async with drive() as driver:
        table = driver.screen.query_one("#runs")
        before = [run.name for run in table.shown]
        send(driver.app, "R", "escape", "S", "R", "escape")
        await driver.until(lambda: [run.name for run in table.shown] == before[::-1])
        assert type(driver.screen).__name__ in ("Home", "Ask")


async def test_a_dangerous_question_is_not_answered_by_a_burst(two, drive):
    async with drive() as driver:
        send(driver.app, "d", *"NSRps")
        screen = await driver.at("Confirm")
        await driver.pilot.pause()
        assert driver.screen is screen
        assert len(driver.app.screen_stack) == 2


async def test_a_removed_widget_does_not_hold_keys(two, drive):
    async with drive() as driver:
        send(driver.app, "slash", *"one", "escape", "enter", "escape", "p")
        await driver.at("Plugins")
