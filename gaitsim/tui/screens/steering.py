"""Steering: a body that the user controls in real time."""

import time
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from rich.style import Style
from rich.text import Text
from textual import work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal.body import draw_body
from gaitsim.render.terminal.chase import VIEWS, chase_camera, draw_path
from gaitsim.render.terminal.curve_view import CurveView
from gaitsim.render.terminal.scales import format_yaw
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.steering import Drive
from gaitsim.tui.formatting import percentage
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.widgets.canvas import CLOSER, BodyCanvas
from gaitsim.tui.widgets.cells import Cells, Picture
from gaitsim.tui.widgets.curve_plot import CurvePlot
from gaitsim.tui.widgets.curves import Series

TURN_SHARE = 0.15  # of the angle to the body's heading that the camera turns per frame
FPS = 20
EVERY = 4  # frames per update of the curve and the plan
BAR = 10  # cells of a full bar
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

    def show(self, drive: Drive, turned: float) -> None:
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

    def zoom_by(self, steps: int) -> None:
        """Zoom in, or out for negative steps."""
        self.zoom = min(max(self.zoom * CLOSER**steps, 0.25), 4.0)
        self.redraw()

    def action_zoom(self, steps: int) -> None:
        self.zoom_by(steps)


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

    def show(self, drive: Drive, turned: float) -> None:
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
    """A body that the arrow keys and space steer.

    Args:
        load: function that returns the body at its start; called in a thread.
        line: equivalent command line.
        clock: function that returns the time in seconds.

    Attributes:
        drive: simulated body; None until it is loaded.
        paused: whether the simulation is paused.
    """

    HELP_TEXT = """
Fly a body yourself. Each command has its own controller, a network that evolution trained for it.
The arrow keys and space choose the controller in command; the others fade out.

- A command **holds until the next key**, because terminals do not report key releases. The
  key of the first command in the list, such as hovering, ends the others.
- The bars show the current share of each controller.
- The flight ends on the ground. **Restart** returns to the start, **Pause** stops the time.
- **View** switches between behind, side and above; the camera turns with the body. + and − zoom.
- The plan shows the path from above, with the initial heading upwards; the curve is the altitude.
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
        load: Callable[[], Drive],
        line: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self._load, self._line, self._clock = load, line, clock
        self.drive: Drive | None = None
        self.paused = False
        self._then, self._elapsed, self._best = 0.0, 0.0, 0.0
        self._frames, self._heading = 0, 0.0
        self._altitudes: list[tuple[float, float]] = []
        self.sub_title = "steering"
        self.body = SteeredBody("reading the controllers …")
        self.plan = PathPlan()
        self.curve = CurvePlot("seconds", "", CurveView())

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
        self._restart_clock()
        self.set_interval(1 / FPS, self._tick)

    def _restart_clock(self) -> None:
        """Restart the clock."""
        self._then, self._elapsed, self.paused = self._clock(), 0.0, False
        self._frames, self._altitudes = 0, []
        self.body.reset_heading()
        self._show()
        self._show_message()

    def _tick(self) -> None:
        """Simulate up to the time of the clock and show the result."""
        now = self._clock()
        passed, self._then = now - self._then, now
        drive = self.drive
        if drive is None or self.paused or drive.ending or not self.is_active:
            return
        self._elapsed += passed
        self._simulate(drive)
        self._show()
        if drive.ending:
            self._best = max(self._best, drive.seconds)
            self._show_message()

    def _simulate(self, drive: Drive) -> None:
        try:
            drive.advance_to(self._elapsed)
        except GaitsimError as error:
            drive.ending = str(error)

    def _show(self) -> None:
        drive = self.drive
        assert drive is not None, "shown only after loading"
        turned = drive.turned
        self._heading = self._heading if turned is None else turned
        self._altitudes.append((drive.seconds, drive.altitude))
        self.body.show(drive, self._heading)
        self.query_one("#steering-facts", Static).update(_facts(drive, self._heading))
        if self._frames % EVERY == 0 or drive.ending:
            self.plan.show(drive, self._heading)
            seconds, altitudes = np.array(self._altitudes).T
            if not self.curve.series:
                self.curve.forget_styles()  # one style per curve
            self.curve.series = (Series("altitude, m", seconds, altitudes),)
            self.curve.redraw()
        self._frames += 1

    def _show_message(self) -> None:
        """Show how keys act, or why the flight has ended."""
        drive = self.drive
        assert drive is not None, "shown only after loading"
        message = self.query_one("#steering-message", Static)
        key = SIGNS[drive.commands[0].key]
        if drive.ending:
            best = f" Best: {self._best:.1f} s." if self._best > drive.seconds else ""
            words = Text(visible_lines(f"{drive.ending}{best} Press r to restart."), "bold")
        elif self.paused:
            words = Text("Paused. Press p to continue.", "bold")
        else:
            words = Text(
                "A command holds until the next key; "
                f"{key} returns to {visible(drive.commands[0].name)}."
            )
        message.update(words)
        self.refresh_bindings()

    def action_command(self, key: str) -> None:
        drive = self.drive
        assert drive is not None, "commands are available after loading"
        drive.choose(next(command.name for command in drive.commands if command.key == key))
        self._show()

    def action_restart(self) -> None:
        drive = self.drive
        assert drive is not None, "available after loading"
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
        self.body.zoom_by(steps)

    def action_back(self) -> None:
        """Go back, or quit if this is the only screen."""
        if len(self.app.screen_stack) > 1:
            super().action_back()
        else:
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
            case "restart" | "view" | "zoom":
                return drive is not None
        return super().check_action(action, parameters)


def _facts(drive: Drive, turned: float) -> Text:
    """Return the time, altitude, speeds, heading, and each command with its share."""
    ahead, up = float(np.hypot(*drive.velocity[:2])), float(drive.velocity[2])
    text = Text(no_wrap=True)
    for name, value in (
        ("flight time", f"{drive.seconds:8.1f} s"),
        ("altitude", f"{drive.altitude:8.2f} m"),
        ("climb", f"{up:+8.2f} m/s".replace("-", "−")),
        ("speed", f"{ahead:8.2f} m/s"),
        ("heading", format_yaw(turned).removeprefix("yaw ").rjust(8)),
    ):
        text.append(f"{name:<12}", "dim")
        text.append(value + "\n")
    text.append("\n")
    widest = max(len(command.name) for command in drive.commands)
    for command, share in zip(drive.commands, drive.shares.tolist(), strict=True):
        chosen = command is drive.command
        style = "bold reverse" if chosen else "bold" if share >= 0.5 / BAR else ""
        text.append(f" {SIGNS[command.key]} {visible(command.name):<{widest}} ", style)
        full = round(share * BAR)
        text.append(" " + "█" * full + "░" * (BAR - full))
        text.append(f" {percentage(share)}\n", "dim")
    return text
