"""Whole sessions in the app with the mouse alone; text is typed."""

import re
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from textual.events import MouseScrollDown
from textual.widgets import Button

pytestmark = pytest.mark.slow
RUN = Path("runs/walk")


def screen_rows(app):
    """Return the rows of text on the screen."""
    compositor = app.screen._compositor
    return ["".join(segment.text for segment in strip) for strip in compositor.render_strips()]


def find_text(app, words, *, last=False):
    """Return the column and row of words on the screen, or in its last row; or None."""
    pattern = re.compile(rf"(?<!\w){re.escape(words)}(?!\w)")
    for row, line in [*enumerate(screen_rows(app))][-1 if last else 0 :]:
        found = pattern.search(line)
        if found:
            return found.start() + len(words) // 2, row
    return None


class Mouse:
    """A user with a mouse, who reads the screen and acts on its text."""

    def __init__(self, driver):
        self.driver, self.app, self.pilot = driver, driver.app, driver.pilot

    async def at(self, kind):
        """Wait for a screen of a class."""
        await self._until(lambda: type(self.app.screen).__name__ == kind, kind)

    async def sees(self, words):
        """Wait until words are on the screen."""
        await self._until(lambda: find_text(self.app, words), words)

    async def _until(self, holds, what):
        try:
            await self.driver.until(holds, 30)
        except TimeoutError:
            pytest.fail("\n".join([f"{what!r} is not shown:", *screen_rows(self.app)]))

    async def write(self, text):
        await self.driver.type(text)

    async def click(self, words, *, times=1):
        await self.sees(words)
        await self.pilot.click(offset=find_text(self.app, words), times=times)
        await self.pilot.pause()

    async def do(self, word):
        """Click an action in the footer, or in the help if the footer is full."""
        active = self.app.screen.active_bindings.values()
        name = next(one.binding.id for one in active if one.binding.description == word)
        for _ in range(60):  # the footer is rebuilt when the available keys change
            before = screen_rows(self.app)[-1]
            await self.pilot.pause(0.3)
            if before == screen_rows(self.app)[-1] and (self._at("More") or self._at("Help")):
                break
        if not await self._foot(word):
            assert await self._foot("More") or await self._foot("Help")
            await self.at("Help")
            shown = self.app.screen
            place = [row.name for row in shown._rows].index(name)
            menu = shown.query_one("#help-keys")
            for _ in range(40):
                rows = menu.scrollable_content_region
                lines = [row for row, (option, _) in enumerate(menu._lines) if option == place]
                row = lines[0] - menu.scroll_offset.y
                if 0 <= row < rows.height:
                    break
                await self.pilot._post_mouse_events([MouseScrollDown], menu, offset=(5, 1))
                await self.pilot.pause()
            await self.pilot.click(menu, offset=(20, row))
        await self.pilot.pause()

    async def _foot(self, word):
        """Click a word of the footer; return whether it was found."""
        found = self._at(word)
        if found:
            await self.pilot.click(offset=found)
            await self.pilot.pause()
        return found is not None

    def _at(self, word):
        return find_text(self.app, word, last=True)

    async def mark(self, name):
        await self.sees(name)
        _, row = find_text(self.app, name)
        await self.pilot.click(offset=(1, row))
        await self.pilot.pause()

    async def open(self, name):
        await self.click(name, times=2)

    async def agree(self, words):
        """Click a button of a dialog."""
        buttons = {str(one.label): one for one in self.app.screen.query(Button)}
        await self.pilot.click(buttons[words])
        await self.pilot.pause()


@pytest.fixture
def run_task(drive):
    """Return a context that yields a user with a mouse on a small screen."""

    @asynccontextmanager
    async def run_task():
        async with drive() as driver:
            yield Mouse(driver)

    return run_task


async def test_comparing_replaying_and_exporting(run_task, walk):
    """Compare and replay runs, choose and explain a generation, and export a file."""
    walk("walk", 5)
    walk("other", 4)
    async with run_task() as user:
        await user.mark("walk")
        await user.mark("other")
        await user.do("Compare")
        await user.at("Compare")
        await user.do("Back")
        await user.at("Home")
        await user.mark("walk")
        await user.mark("other")
        await user.open("walk")
        await user.at("Live")
        await user.do("Replay")
        await user.at("Replay")
        await user.sees("generation 5")
        await user.do("Generation")
        await user.do("Go to")
        await user.at("Ask")
        await user.write("2")
        await user.agree("OK")
        await user.sees("generation 2")
        await user.do("Why")
        await user.at("Why")
        await user.sees("reach")
        await user.do("Back")
        await user.do("Export")
        await user.at("ExportDialog")
        await user.sees("--generation 2")
        await user.agree("Export")
        await user.driver.until(lambda: [*RUN.glob("exports/*")])
        await user.at("Replay")
        await user.do("Back")
        await user.at("Live")
        await user.do("Back")
        await user.at("Home")
