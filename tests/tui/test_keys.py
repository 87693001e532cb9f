"""Bursts of keys: what is typed while a dialog opens or closes reaches the dialog."""

from collections import defaultdict
from importlib import import_module
from pkgutil import walk_packages

import pytest
from rich.text import Text
from textual.events import Key
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Input, TextArea

from gaitsim.tui import screens
from gaitsim.tui.screens.base import Dialog
from gaitsim.tui.screens.export_dialog import ExportDialog
from gaitsim.tui.screens.files import ChooseFile
from gaitsim.tui.screens.help import Help
from gaitsim.tui.screens.presets import Presets
from gaitsim.tui.screens.questions import Ask, AskText, Choose, Confirm, PickTrashed
from gaitsim_studies.study_dialog import SWEEP, StudyDialog

BURST = "nRpSds/xqcf"  # letters that have a meaning on the screens below


def send(app, *keys):
    """Send keys at once, as a fast typist does."""
    for key in keys:
        letters = {"slash": "/", "question_mark": "?"}
        name = {"/": "slash"}.get(key, key)
        app.post_message(Key(name, letters.get(key, key if len(key) == 1 else None)))


def text_of(screen):
    field = screen.app.focused
    assert isinstance(field, Input | TextArea)
    return field.text if isinstance(field, TextArea) else field.value


@pytest.fixture
def two(walk):
    walk("one", 3)
    walk("two", 4)


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("opening", "dialog"),
    [
        (["R"], "Ask"),  # rename
        (["B"], "Ask"),  # gallery
        (["N"], "AskText"),
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
            send(driver.app, *["escape"] * (len(opening) + (dialog == "AskText")), "j", "j")
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


MANY = ("RNSDLMB" * 8)[:50]  # capital letters, which close no dialog and act on screens below


@pytest.fixture
def received(monkeypatch):
    """The keys that each class of screens has received."""
    keys = defaultdict(str)
    seen = []  # a screen forwards an event to the focused widget

    def recording(forward):
        def record(widget, event):
            if isinstance(event, Key) and event.character and event not in seen:
                seen.append(event)
                keys[type(widget.screen).__name__] += event.character
            return forward(widget, event)

        return record

    for kind in (Widget, Screen):
        monkeypatch.setattr(kind, "_forward_event", recording(kind._forward_event))
    return keys


DIALOGS = {
    "Confirm": lambda home: Confirm("Really?", "Yes", danger=True),
    "Choose": lambda home: Choose("Which?", {"k": "Keep", "s": "Stop"}),
    "Ask": lambda home: Ask("Name?"),
    "PickTrashed": lambda home: PickTrashed("Which?", {"one": Text("One")}),
    "AskText": lambda home: AskText("What?"),
    "ExportDialog": lambda home: ExportDialog(home.runs[0].path),
    "StudyDialog": lambda home: StudyDialog(SWEEP),
    "Presets": lambda home: Presets(),
    "ChooseFile": lambda home: ChooseFile(),
    "Help": Help,
}


def test_every_dialog_is_in_the_table():
    for module in walk_packages(screens.__path__, "gaitsim.tui.screens."):
        import_module(module.name)
    assert {kind.__name__ for kind in Dialog.__subclasses__()} == {*DIALOGS}


async def test_keys_held_at_the_end_of_the_app_are_dropped(two, drive):
    async with drive() as driver:
        app = driver.app
        app._keys.append(Key("x", "x"))
        stack = app._screen_stack[:]
        app._screen_stack.clear()  # as when the window of a browser closes
        await app._deliver()
        assert app.holds_keys
        app._screen_stack.extend(stack)


@pytest.mark.sampled
@pytest.mark.parametrize("dialog", DIALOGS)
async def test_every_dialog_receives_a_burst(two, drive, received, dialog):
    async with drive() as driver:
        app = driver.app
        opened = DIALOGS[dialog](driver.screen)
        app.run_worker(app.push_screen_wait(opened), group="ask")
        send(app, *MANY)
        await driver.until(lambda: sum(map(len, received.values())) == len(MANY), 10)
        await driver.until(lambda: not app.holds_keys)
        assert received == {dialog: MANY}
        assert driver.screen is opened
        if dialog in ("Ask", "AskText"):
            await driver.until(lambda: text_of(opened) == MANY)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("opening", "dialog"),
    [
        (["e"], "ExportDialog"),
        (["d"], "Confirm"),
        (["question_mark"], "Help"),
        (["ctrl+p"], "CommandPalette"),
        (["u", "n"], "StudyDialog"),
        (["u", "c"], "StudyDialog"),
        (["n"], "Presets"),
        (["n", "ctrl+l"], "ChooseFile"),
        (["n", "enter", "slash"], "CommandPalette"),
    ],
)
async def test_dialogs_receive_a_burst_after_their_keys(two, drive, received, opening, dialog):
    async with drive() as driver:
        keys = {"question_mark": "?", "slash": "/"}
        characters = sum(1 for key in opening if len(keys.get(key, key)) == 1)
        send(driver.app, *opening, *MANY)
        total = characters + len(MANY)
        await driver.until(lambda: sum(map(len, received.values())) == total, 15)
        assert received[dialog] == MANY, dict(received)


async def test_a_key_after_enter_does_not_cancel_a_change(two, drive):
    async with drive() as driver:
        await driver.press("enter")
        live = await driver.at("Live")
        await driver.until(lambda: "live.change" in driver.offered())
        changes = []
        live._continue = changes.append
        await driver.press("c")
        form = await driver.at("ChangeForm")
        await driver.until(lambda: form.validation is not None)
        form.go_to("fitness.price")
        await driver.until(lambda: isinstance(driver.app.focused, Input))
        driver.app.focused.value = ""
        send(driver.app, *"0.3", "enter", "x", "l")
        await driver.at("Live")
        assert changes == [{"fitness.price": "0.3"}]
