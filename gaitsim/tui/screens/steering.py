"""Steering: a body that the user controls in real time."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np
from rich.style import Style
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Static

from gaitsim.contracts import Command
from gaitsim.errors import GaitsimError
from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal.body import draw_body
from gaitsim.render.terminal.chase import VIEWS, chase_camera, draw_path
from gaitsim.render.terminal.scales import format_yaw
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.steering import SteeredDrive
from gaitsim.storage.files.folder import command
from gaitsim.tui.formatting import percentage
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.widgets.canvas import CLOSER, BodyCanvas
from gaitsim.tui.widgets.cells import Cells, Picture
from gaitsim.tui.widgets.curves import CurvePlot, Series

TURN_SHARE = 0.15  # of the angle to the body's heading that the camera turns per frame
FPS = 20
EVERY = 4  # frames per update of the curve and the plan
BAR = 10  # cells of a full bar
WIDE = 15  # cells of a command in a list of two columns
SHORT = 3.0  # s; nobody is asked to save less of a drive
SIGNS = {"up": "↑", "down": "↓", "left": "←", "right": "→", "space": "␣"}


class SteeredBody(BodyCanvas, can_focus=False):
    """A steered body, seen by a camera that turns with it.

    Attributes:
        camera: name of the camera, one of `gaitsim.render.terminal.chase.VIEWS`.
        zoom: zoom factor; 1 for the default distance.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message=message)
        self.camera = next(iter(VIEWS))
        self.zoom = 1.0
        self._length = 1.0
        self._turned = self._looking = 0.0

    def show(self, drive: SteeredDrive, turned: float) -> None:
        """Show the current state of a body.

        Args:
            drive: simulated body.
            turned: heading relative to that at the start, positive to the left, radians.
        """
        self._turned = turned
        away = (turned - self._looking + np.pi) % (2 * np.pi) - np.pi
        self._looking += TURN_SHARE * away
        self._body = Clip(drive.skeleton)
        self._length = drive.size
        self.redraw()

    def reset_heading(self) -> None:
        """Turn the camera to the initial heading immediately."""
        self._looking = 0.0

    def picture(self, columns: int, rows: int) -> Picture:
        clip = self._body
        assert clip is not None, "else the placeholder is shown"
        pose = clip.at(clip.seconds)
        eye = chase_camera(
            self.camera, self._looking, pose.aim, self._length, self.zoom, columns, rows
        )
        return draw_body(eye, clip, pose, self._turned, columns, rows)

    def next_camera(self) -> None:
        """Switch to the next camera."""
        names = [*VIEWS]
        self.camera = names[(names.index(self.camera) + 1) % len(names)]
        self.redraw()

    def action_zoom(self, steps: int) -> None:
        """Zoom in, or out for negative steps."""
        self.zoom = min(max(self.zoom * CLOSER**steps, 0.25), 4.0)
        self.redraw()


class PathPlan(Cells):
    """The path of a steered body from above."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"path--way", "path--body", "path--scale"}
    DEFAULT_CSS = """
    PathPlan {
        height: 1fr;
        & > .path--way { color: $success; }
        & > .path--body { color: $foreground; text-style: bold; }
        & > .path--scale { color: $foreground 60%; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self._path = np.zeros((1, 3))
        self._turned, self._length = 0.0, 1.0

    def show(self, drive: SteeredDrive, turned: float) -> None:
        """Show the path of a body; `turned` as in `SteeredBody.show`."""
        self._path, self._turned = drive.path, turned
        self._length = drive.size
        self.redraw()

    def picture(self, columns: int, rows: int) -> Picture:
        return draw_path(self._path, self._turned, self._length, columns, rows)

    def ink_styles(self) -> list[Style]:
        """Return the styles of blank, path, body and scale."""
        parts = ("path--way", "path--body", "path--scale")
        return [self.ink_style(), *map(self.ink_style, parts)]


class Steering(GaitScreen):
    """A body that a person steers with the arrow keys and some letters.

    Args:
        load: function that returns the body at its start; called in a thread.
        line: equivalent command line.
        clock: function that returns the time in seconds.
        record: folder in which each drive is saved without asking; a number is added to an existing
            name. None asks about drives that are not saved.

    Attributes:
        drive: simulated body; None until it is loaded.
        paused: whether the simulation is paused.
        saved: folders of the runs in which drives were saved.
    """

    HELP_TEXT = """
Steer a body yourself: drive a robot in physics, or fly a fly.

- The list beside the picture shows the **commands** with their keys. Terminals do not report key
  releases, so a command holds: a robot keeps its speed and turn, and each press changes them by
  a step. The first command in the list ends the others.
- Each key of the **fly** has its own controller, a network that evolution trained for it. Bars
  show the current share of each controller.
- A flight ends on the ground, and a drive when the robot falls. **Restart** returns to the start,
  **Pause** stops the time.
- **Save** stores the drive of a robot as a run, which you can replay, export and film.
- **View** switches between behind, side and above; the camera turns with the body. + and − zoom.
- The plan shows the path from above, with the initial heading upwards; the curve is the altitude
  of a flying body, or the speed of a walking one.
"""
    BINDINGS = bindings("steering")
    DEFAULT_CSS = """
    Steering {
        & #steering { height: 1fr; }
        & #steering-side { width: 31; border-left: solid $border-blurred; }
        & #steering-facts { height: auto; padding: 0 1; }
        & #steering-curve { height: 10; display: none; }
        & #steering-message { height: auto; max-height: 3; padding: 0 1; background: $surface; }
        &.-tall #steering-curve { display: block; }
        &.-wide #steering-side { width: 44; }
    }
    """
    AUTO_FOCUS = ""

    def __init__(
        self,
        load: Callable[[], SteeredDrive],
        line: str = "",
        clock: Callable[[], float] = time.monotonic,
        record: Path | None = None,
    ) -> None:
        super().__init__()
        self._load, self._line, self._clock, self._record = load, line, clock, record
        self.drive: SteeredDrive | None = None
        self.paused = self._saving = False
        self.saved: list[Path] = []
        self._saved_until = 0.0  # s
        self._then, self._elapsed, self._best = 0.0, 0.0, 0.0
        self._frames, self._heading = 0, 0.0
        self._recordable = False
        self._curve: list[tuple[float, float]] = []
        self._said = ""
        self.sub_title = "steering"
        self.body = SteeredBody("preparing the body …")
        self.plan = PathPlan()
        self.curve = CurvePlot("seconds")

    def content(self) -> ComposeResult:
        with Horizontal(id="steering"):
            yield self.body
            with Vertical(id="steering-side"):
                yield Static(id="steering-facts")
                yield self.plan
                with Vertical(id="steering-curve"):
                    yield self.curve
        yield Static(id="steering-message")

    @work(group="read")
    async def on_mount(self) -> None:
        try:
            self.drive = await self.in_thread(self._load)
        except GaitsimError as error:
            self.body.show_message(visible_lines(str(error)))
            self.query_one("#steering-message").display = False
            return
        self._recordable = self.drive.recordable
        self.sub_title = f"steering {self.drive.experiment.name}"
        self._restart_clock()
        self.set_interval(1 / FPS, self._tick)

    def _restart_clock(self) -> None:
        """Restart the clock."""
        self._then, self._elapsed, self.paused = self._clock(), 0.0, False
        self._frames, self._curve, self._saved_until = 0, [], 0.0
        self.body.reset_heading()
        self._show()
        self._show_message()

    def _tick(self) -> None:
        """Simulate up to the time of the clock and show the result."""
        now = self._clock()
        passed, self._then = now - self._then, now
        drive = self.drive
        if drive is None or self.paused or self._saving or drive.ending or not self.is_active:
            return
        self._elapsed += passed
        self._simulate(drive)
        self._show()
        if drive.ending:
            self._best = max(self._best, drive.seconds)
        if drive.ending or self._notice(drive) != self._said:
            self._show_message()

    def _simulate(self, drive: SteeredDrive) -> None:
        try:
            drive.advance_to(self._elapsed)
        except GaitsimError as error:
            drive.ending = str(error)

    def _show(self) -> None:
        drive = self.drive
        assert drive is not None, "shown only after loading"
        turned = drive.turned
        self._heading = self._heading if turned is None else turned
        speed = float(np.hypot(*drive.velocity[:2]))
        self._curve.append((drive.seconds, drive.altitude if drive.flies else speed))
        self.body.show(drive, self._heading)
        self.query_one("#steering-facts", Static).update(_facts(drive, self._heading))
        if self._frames % EVERY == 0 or drive.ending:
            self.plan.show(drive, self._heading)
            seconds, values = np.array(self._curve).T
            if not self.curve.series:
                self.curve.forget_styles()  # one style per curve
            name = "altitude, m" if drive.flies else "speed, m/s"
            self.curve.series = (Series(name, seconds, values),)
            self.curve.redraw()
        self._frames += 1

    def _show_message(self) -> None:
        """Show how keys act, what the body cannot do, or why the drive has ended."""
        drive = self.drive
        assert drive is not None, "shown only after loading"
        self._said = self._notice(drive)
        message = self.query_one("#steering-message", Static)
        key, first = sign(drive.commands[0].key), visible(drive.commands[0].name)
        save = " Press Ctrl-S to save the drive." if self._unsaved else ""
        if drive.ending:
            best = f" Best: {self._best:.1f} s." if self._best > drive.seconds else ""
            words = Text(visible_lines(f"{drive.ending}{best} Press r to restart.{save}"), "bold")
        elif self.paused:
            words = Text(f"Paused. Press p to continue.{save}", "bold")
        elif self._said:
            words = Text(visible_lines(self._said), "bold")
        elif drive.holds:
            words = Text(f"A command holds until the next key; {key} returns to {first}.")
        else:
            words = Text(f"Each press is a step, and commands hold; {key} is {first}.")
        message.update(words)
        self.refresh_bindings()

    def _notice(self, drive: SteeredDrive) -> str:
        try:
            return drive.notice
        except GaitsimError as error:
            drive.ending = str(error)
            return ""

    @property
    def _unsaved(self) -> bool:
        """Whether a drive with commands can be saved and has not been."""
        drive = self.drive
        if drive is None or not self._recordable or not drive.given:
            return False
        return drive.saved is None and not self._saving

    def action_command(self, key: str) -> None:
        drive = self.drive
        assert drive is not None, "commands are available after loading"
        try:
            drive.give(next(one.name for one in drive.commands if one.key == key))
        except GaitsimError as error:
            drive.ending = str(error)
        self._show()
        self._show_message()

    @work(group="ask", exclusive=True)
    async def action_save(self) -> None:
        await self._save()

    async def _save(self) -> bool:
        """Save the drive as a run; return whether it was possible."""
        drive = self.drive
        assert drive is not None, "available after loading"
        self._saving = True
        self.query_one("#steering-message", Static).update("Saving the drive …")
        try:
            path = await self.in_thread(drive.save, self._record)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
            return False
        finally:
            self._saving = False
            if self.is_mounted:
                self._show_message()
        self.saved.append(path)
        self._saved_until = drive.seconds
        text = f"{path}: a drive of {drive.seconds:.1f} s. Replay it: {command('play', path)}"
        self.app.notify(text, title="Saved", markup=False)
        return True

    async def may_leave(self) -> bool:
        """Return whether the drive may be discarded, after saving it or asking where necessary."""
        from gaitsim.tui.screens.questions import Choose

        drive = self.drive
        if drive is None or not self._unsaved or drive.seconds - self._saved_until < SHORT:
            return True
        if self._record is not None:
            return await self._save()
        question = f"Save the drive of {drive.seconds:.1f} s as a run?"
        choose = Choose(question, {"s": "Save", "d": "Discard"})
        answer = await self.app.push_screen_wait(choose)
        return answer == "d" or (answer == "s" and await self._save())

    @work(group="restart", exclusive=True)
    async def action_restart(self) -> None:
        drive = self.drive
        assert drive is not None, "available after loading"
        if not await self.may_leave():
            return
        self._best = max(self._best, drive.seconds)
        try:
            drive.restart()
        except GaitsimError as error:
            self.gaitsim.show_error(error)
            return
        self._restart_clock()

    def action_pause(self) -> None:
        self.paused = not self.paused
        self._show_message()

    def action_view(self) -> None:
        self.body.next_camera()

    def action_zoom(self, steps: int) -> None:
        self.body.action_zoom(steps)

    async def _leave(self) -> None:
        """Go back, or quit if this is the only screen."""
        if len(self.app.screen_stack) > 1:
            await super()._leave()
        elif self.is_current and await self.may_leave():
            self.app.exit()

    def command_line(self) -> str:
        return self._line

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        drive = self.drive
        match action:
            case "back":
                return True
            case "command":
                keys = [] if drive is None else [command.key for command in drive.commands]
                return drive is not None and not drive.ending and parameters[0] in keys
            case "pause":
                return drive is not None and not drive.ending
            case "save":
                return self._unsaved
            case "restart" | "view" | "zoom":
                return drive is not None
        return super().check_action(action, parameters)


def sign(key: str) -> str:
    """Return the character that stands for a key."""
    return SIGNS.get(key, key)


def _facts(drive: SteeredDrive, turned: float) -> Text:
    """Return the time, the place, the speeds, what the body is asked to do, and the commands."""
    ahead, up = float(np.hypot(*drive.velocity[:2])), float(drive.velocity[2])
    rows = {"flight time" if drive.flies else "time": f"{drive.seconds:8.1f} s"}
    if drive.flies:
        rows["altitude"] = f"{drive.altitude:8.2f} m"
        rows["climb"] = f"{up:+8.2f} m/s".replace("-", "−")
    rows["speed"] = f"{ahead:8.2f} m/s"
    rows["heading"] = format_yaw(turned).removeprefix("yaw ").rjust(8)
    text = Text(no_wrap=True)
    for name, value in drive.facts.items():
        number, _, unit = visible(value).partition(" ")
        rows[visible(name)] = f"{number:>8} {unit}"
    for name, value in rows.items():
        text.append(f"{name:<12}", "dim")
        text.append(value + "\n")
    text.append("\n")
    if drive.holds:
        _add_controllers(text, drive)
    else:
        _add_commands(text, drive.commands)
    return text


def _add_controllers(text: Text, drive: SteeredDrive) -> None:
    """Add each command on its own line, with the share of its controller."""
    widest = max(len(one.name) for one in drive.commands)
    active = [float(one is drive.command) for one in drive.commands]
    shares = active if drive.shares is None else drive.shares.tolist()
    for one, share in zip(drive.commands, shares, strict=True):
        chosen = one is drive.command
        style = "bold reverse" if chosen else "bold" if share >= 0.5 / BAR else ""
        text.append(f" {sign(one.key)} {visible(one.name):<{widest}} ", style)
        full = round(share * BAR)
        text.append(" " + "█" * full + "░" * (BAR - full))
        text.append(f" {percentage(share)}\n", "dim")


def _add_commands(text: Text, commands: Sequence[Command]) -> None:
    """Add the commands in two columns."""
    for number, one in enumerate(commands):
        text.append(f"{sign(one.key)} ", "bold")
        last = number % 2 or number == len(commands) - 1
        name = visible(one.name)
        text.append(f"{name}\n" if last else f"{name:<{WIDE - 2}}")
