"""Fixtures that drive the app's screens in a temporary folder with runs of puppets."""

from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from textual import _wait, constants
from textual._compositor import Compositor
from textual.css.model import RuleSet
from textual.css.stylesheet import Stylesheet
from waiting import app_until

from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.config import read_config

# Waiting for an idle app takes a second while something moves; shorter intervals avoid this.
_wait.SLEEP_GRANULARITY = 1 / 200
_wait.SLEEP_IDLE = _wait.SLEEP_GRANULARITY / 20

constants.TEXTUAL_ANIMATIONS = "none"  # each step of an animation draws the screen

# Each new app would parse the same style sheets.
_parse_rules = Stylesheet._parse_rules
_parsed = {}


def _parse_once(sheet, *arguments, **options):
    key = (tuple(sheet._variables.items()), arguments, tuple(options.items()))
    if key not in _parsed:
        _parsed[key] = _parse_rules(sheet, *arguments, **options)
    return _parsed[key]


Stylesheet._parse_rules = _parse_once

# A hash in Python of each rule, for each widget, takes a tenth of the time of these tests.
RuleSet.__hash__ = object.__hash__

# Without a terminal, Textual draws each change, a fifth of the time of a test, and discards it.
_draw = Compositor.render_update


def _draw_if_wanted(compositor, full=False, **options):
    if full:
        return _draw(compositor, full, **options)
    compositor._dirty_regions.clear()
    return None


Compositor.render_update = _draw_if_wanted


class RecordingApp(GaitsimApp):
    """The app, which also records its notifications."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.notified = []

    def notify(self, message, *, title="", **options):
        self.notified.append(f"{title} {message}")
        super().notify(message, title=title, **options)


class Driver:
    """An app, and a pilot that presses its keys."""

    def __init__(self, app, pilot):
        self.app = app
        self.pilot = pilot

    @property
    def screen(self):
        return self.app.screen

    async def press(self, *keys):
        """Press keys and wait until all of them are handled."""
        await self.pilot.press(*keys)
        await self.until(lambda: not (self.app.is_running and self.app.holds_keys))

    async def type(self, text):
        await self.press(*(char if char.isalnum() else _NAMES[char] for char in text))

    async def until(self, holds, seconds=60):
        """Wait until a condition holds."""
        await app_until(self.pilot, holds, seconds)

    async def at(self, kind):
        """Wait for a screen of a class and return it."""
        await self.until(lambda: type(self.app.screen).__name__ == kind)
        return self.app.screen

    def offered(self):
        """Return the ids of the available bindings."""
        return {
            active.binding.id
            for active in self.screen.active_bindings.values()
            if active.enabled and active.binding.id
        }

    def notifications(self):
        """Return the texts of all notifications."""
        return "\n".join(self.app.notified)

    def text(self, selector):
        """Return the text of a widget."""
        return str(self.screen.query_one(selector).render())


_NAMES = {" ": "space", "[": "left_square_bracket", "]": "right_square_bracket", ".": "full_stop"}
_NAMES |= {"-": "minus", "/": "slash", "_": "underscore"}


@pytest.fixture(autouse=True)
def state_folder(tmp_path, monkeypatch):
    """Keep the options of a real robot out of the home folder."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def config(here):
    """Return a function that reads settings from a text."""

    def config(text):
        path = here / "config.toml"
        path.write_text(text)
        return read_config(path)

    return config


@pytest.fixture
def drive():
    """Return a context that runs a new app and drives it, once home lists its runs."""

    @asynccontextmanager
    async def drive(*, size=(80, 24), folder=Path("runs"), ready=True, **options):
        app = RecordingApp(folder, **options)
        async with app.run_test(size=size) as pilot:
            driver = Driver(app, pilot)
            home = app.screen
            if ready:
                await driver.until(lambda: home.runs is not None)
                await driver.until(
                    lambda: not home.runs or any(one.shown for one in home.query("#runs"))
                )
            yield driver
            # A process that outlives the event loop would fail a later test.
            await app.tasks.stop_all()

    return drive
