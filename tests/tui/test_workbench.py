"""A day at the workbench: the same tasks by the keyboard alone and by the mouse alone.

Text is typed in both: a mouse has no letters.
"""

import re
from pathlib import Path

import pytest
from textual.events import MouseScrollDown
from textual.widgets import Button

from gaitsim.live.background import evolving
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.tui.widgets.curves import Curves

pytestmark = pytest.mark.slow
RUN = Path("runs/walk")


def shown(app):
    """The rows of text on the screen."""
    compositor = app.screen._compositor
    return ["".join(segment.text for segment in strip) for strip in compositor.render_strips()]


def place(app, words, *, last=False):
    """Where words stand on the screen, or in its last row, as cells; None where they do not."""
    pattern = re.compile(rf"(?<!\w){re.escape(words)}(?!\w)")
    for row, line in [*enumerate(shown(app))][-1 if last else 0 :]:
        found = pattern.search(line)
        if found:
            return found.start() + len(words) // 2, row
    return None


class Hand:
    """One who looks at the screen, and acts on what stands there."""

    def __init__(self, driver):
        self.driver, self.app, self.pilot = driver, driver.app, driver.pilot

    async def at(self, kind):
        """Wait for a screen of that class."""
        await self._until(lambda: type(self.app.screen).__name__ == kind, kind)

    async def sees(self, words):
        """Wait until words stand on the screen."""
        await self._until(lambda: place(self.app, words), words)

    async def _until(self, holds, what):
        try:
            await self.driver.until(holds, 30)
        except TimeoutError:
            pytest.fail("\n".join([f"{what!r} is not there:", *shown(self.app)]))

    async def write(self, text):
        await self.driver.type(text)

    async def click(self, words, *, times=1):
        await self.sees(words)
        await self.pilot.click(offset=place(self.app, words), times=times)
        await self.pilot.pause()


class Keyboard(Hand):
    async def do(self, key, _word):
        """Press the key of an action."""
        await self.driver.press(key)

    async def on_run(self, name):
        """Put the cursor of the list on a run."""
        table = self.app.screen.query_one("#runs")
        await self.driver.press("g", "g")
        while self.app.screen.current().name != name:
            assert table.cursor_row < table.row_count - 1
            await self.driver.press("j")

    async def mark(self, name):
        await self.on_run(name)
        await self.driver.press("space")

    async def open(self, name):
        await self.on_run(name)
        await self.driver.press("enter")

    async def take(self, _words):
        """Take the first suggestion."""
        await self.driver.press("down", "enter")

    async def agree(self, _words):
        """Take what a dialog proposes."""
        await self.driver.press("enter")

    async def confirm(self, key, _words):
        """Press the key of a dialog's button."""
        await self.driver.press(key)

    async def tool(self, key, _word):
        """Press the key of a curve's tool."""
        self.app.screen.query_one(Curves).focus()
        await self.driver.press(key)


class Mouse(Hand):
    async def do(self, key, word):
        """Click an action in the footer, or in the help where the footer has no room."""
        active = self.app.screen.active_bindings.values()
        about = next(one.binding.tooltip for one in active if one.binding.description == word)
        about = " ".join(about.split()[1:3]).rstrip(",")
        for _ in range(60):  # the footer is made anew when other keys work
            before = shown(self.app)[-1]
            await self.pilot.pause(0.3)
            if before == shown(self.app)[-1] and (self._at("More") or self._at("Help")):
                break
        if not await self._foot(word):
            assert await self._foot("More") or await self._foot("Help")
            await self.at("Help")
            for _ in range(40):
                if place(self.app, about):
                    break
                down = [MouseScrollDown]
                await self.pilot._post_mouse_events(down, "#help", offset=(5, 5))
                await self.pilot.pause()
            await self.click(about)
        await self.pilot.pause()

    async def _foot(self, word):
        """Click a word of the footer; return whether it is there."""
        found = self._at(word)
        if found:
            await self.pilot.click(offset=found)
            await self.pilot.pause()
        return found is not None

    def _at(self, word):
        return place(self.app, word, last=True)

    async def mark(self, name):
        await self.sees(name)
        _, row = place(self.app, name)
        await self.pilot.click(offset=(1, row))
        await self.pilot.pause()

    async def open(self, name):
        await self.click(name, times=2)

    async def take(self, words):
        await self.click(words)

    async def agree(self, words):
        """Click a button of a dialog."""
        buttons = {str(one.label): one for one in self.app.screen.query(Button)}
        await self.pilot.click(buttons[words])
        await self.pilot.pause()

    async def confirm(self, _key, words):
        await self.agree(words)

    async def tool(self, _key, word):
        await self.click(word)


async def at_rest(hand, name, state):
    """Wait until home shows a run in a state."""

    def holds():
        runs = {run.name: run for run in hand.app.screen.runs or ()}
        return name in runs and runs[name].state == state

    await hand.driver.until(holds)


@pytest.fixture(params=[(Keyboard, (120, 34)), (Mouse, (80, 24))], ids=["keyboard", "mouse"])
def day(request, drive):
    """Runs a task with one of the two hands on the app; the mouse where the footer is short."""
    hand, size = request.param

    def day(task):
        async def test(driver):
            await task(hand(driver))

        drive(test, size=size)

    return day


def test_steering(day, walk):
    """A run is continued, left, found again, changed, forked and stopped."""
    walk("walk", 3, "organism.pause=0.01", generations=4000)

    async def task(hand):
        await hand.open("walk")
        await hand.at("Live")
        await hand.do("space", "Resume")
        await hand.sees("Pause")
        await hand.do("escape", "Back")
        await hand.at("Home")
        await at_rest(hand, "walk", "running")
        await hand.open("walk")
        await hand.at("Live")
        await hand.sees("running")
        await hand.do("c", "Change")
        await hand.at("ChangeDialog")
        await hand.write("pric")
        await hand.sees("Continue typing")
        await hand.take("fitness.price")
        await hand.write("4")
        await hand.sees("now 4.0")
        await hand.agree("Change")
        await hand.at("Live")
        await hand.sees("stage 2")
        await hand.do("f", "Fork")
        await hand.at("ChangeDialog")
        await hand.agree("Fork")
        await hand.driver.until(lambda: evolving(Path("runs/walk-2")) == "running")
        await hand.sees("walk-2")
        await hand.do("s", "Stop")
        await hand.sees("stopped")
        await hand.do("escape", "Back")
        await hand.sees("walk — puppet")
        await hand.do("escape", "Back")
        await hand.at("Home")
        await hand.mark("walk")
        await hand.do("x", "Stop")
        await at_rest(hand, "walk", "stopped")

    day(task)
    run = RunSnapshot(RUN)
    assert [str(change) for change in run.stages[1].changes]
    assert evolving(RUN) is evolving(Path("runs/walk-2")) is None


def test_looking(day, walk):
    """Runs are compared and replayed, a generation is chosen and with_failure, a file is made."""
    walk("walk", 5)
    walk("other", 4)

    async def task(hand):
        await hand.mark("walk")
        await hand.mark("other")
        await hand.do("c", "Compare")
        await hand.at("Compare")
        await hand.tool("m", "smooth")
        await hand.sees("median of")
        await hand.tool("0", "all")
        await hand.tool("m", "smooth")
        await hand.do("escape", "Back")
        await hand.at("Home")
        await hand.mark("walk")
        await hand.mark("other")
        await hand.open("walk")
        await hand.at("Live")
        await hand.do("r", "Replay")
        await hand.at("Replay")
        await hand.sees("generation 5")
        await hand.do("left_square_bracket", "Generation")
        await hand.do("g", "Go to")
        await hand.at("Ask")
        await hand.write("2")
        await hand.agree("OK")
        await hand.sees("generation 2")
        await hand.do("w", "Why")
        await hand.at("Why")
        await hand.sees("reach")
        await hand.do("escape", "Back")
        await hand.do("e", "Export")
        await hand.at("ExportDialog")
        await hand.sees("--generation 2")
        await hand.agree("Export")
        await hand.driver.until(lambda: [*RUN.glob("exports/*")])
        await hand.at("Replay")
        await hand.do("escape", "Back")
        await hand.at("Live")
        await hand.do("escape", "Back")
        await hand.at("Home")

    day(task)


def test_keeping(day, walk):
    """Runs are verified, noted, found by a word of the note, and deleted."""
    walk("walk", 5)
    walk("other", 4)

    async def task(hand):
        await hand.open("walk")
        await hand.at("Live")
        await hand.do("v", "Verify")
        await hand.at("Verify")
        await hand.sees("identical")
        await hand.do("escape", "Back")
        await hand.at("Live")
        await hand.do("escape", "Back")
        await hand.at("Home")
        await hand.do("N", "Note")
        await hand.at("NoteDialog")
        await hand.write("it walks")
        await hand.confirm("ctrl+s", "Save")
        await hand.at("Home")
        await hand.do("slash", "Filter")
        await hand.write("walks")
        await hand.driver.until(lambda: not place(hand.app, "other"))
        await hand.do("escape", "Back")
        await hand.mark("walk")
        await hand.mark("other")
        await hand.do("d", "Delete")
        await hand.at("Confirm")
        await hand.confirm("y", "Delete")
        await hand.driver.until(lambda: not RUN.exists())

    day(task)
    assert not Path("runs/other").exists()
