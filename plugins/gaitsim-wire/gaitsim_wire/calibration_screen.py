"""The screen on which a person calibrates a robot, joint by joint."""

import math

import numpy as np
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.widgets import Static

from gaitsim.plugin.pictures import visible, visible_lines
from gaitsim.screen import BodyCanvas, GaitScreen, bindings
from gaitsim_wire.calibrating import STEPS, Calibrator, drawn

FPS = 10
NOTHING = "does not answer"
TASKS = {
    "move": "Press ↑ and ↓; ← and → are small steps. Does the marked joint turn as in the picture? "
    "Enter: yes. d: it turns the other way. n: another joint turns.",
    "stand": "Turn the joint until it stands as in the picture, and press Enter. With the servo "
    "off (Space), you can turn it by hand.",
    "low": "Turn the joint down until parts almost touch, and press Enter; or press k to keep both "
    "ends of the model.",
    "high": "Turn the joint up until parts almost touch, and press Enter; or press k to keep both "
    "ends of the model.",
}
TITLES = "turns as in the picture", "standing pose", "lower end", "upper end"


class RobotPicture(BodyCanvas, can_focus=False):
    """The picture that the real robot should look like."""


class CalibrationScreen(GaitScreen):
    """A robot whose servos a person turns one by one, beside a picture.

    Args:
        calibrator: the robot, which another thread serves.
        line: equivalent command line.
        after: command to continue with.
    """

    HELP_TEXT = """
Calibrate a real robot: find the direction, the standing pose and the ends of each servo.

- **Hang the robot up** first, and keep your fingers away from the legs. Torque is on only for the
  servo that you turn; **Space** switches it off at once, and so do heat, a low voltage, a servo
  that does not answer, and the end of the program.
- The picture shows what the marked joint should do. **Arrow keys** turn the servo slowly; it stops
  where it is blocked. With its torque off, you can also turn the joint by hand.
- **Enter** answers a question. The last answer saves the joint in the calibration
  file. You can quit after each joint, and continue later.
- **[ and ]** choose another joint, also to calibrate it again.
- **Check** lets the robot stand, and sways each joint by 5°, as the picture shows.
"""
    BINDINGS = bindings("calibration")
    DEFAULT_CSS = """
    CalibrationScreen {
        & #calibration { height: 1fr; }
        & #calibration-side { width: 33; border-left: solid $border-blurred; padding: 0 1; }
        & #calibration-task { height: auto; max-height: 6; padding: 0 1; background: $surface; }
    }
    """
    AUTO_FOCUS = ""

    def __init__(self, calibrator: Calibrator, line: str, after: str) -> None:
        super().__init__()
        self.calibrator, self._line, self._after = calibrator, line, after
        self.picture = RobotPicture(message="drawing the robot …")
        self.picture.ground = False  # the robot hangs
        self._shown = ""
        self.sub_title = f"calibrating {calibrator.path}"

    def content(self) -> ComposeResult:
        with Horizontal(id="calibration"):
            yield self.picture
            with Vertical(id="calibration-side"):
                yield Static(id="calibration-facts")
        yield Static(id="calibration-task")

    def on_mount(self) -> None:
        self._show()
        self.set_interval(1 / FPS, self._show)

    def _show(self) -> None:
        found = self.calibrator
        shown = "" if found.checking else found.name
        if shown != self._shown or self.picture.skeleton is None:
            self._shown = shown
            robot = drawn(found.robot, found.swaying) if found.checking else found.picture()
            self.picture.set_skeleton(robot)
        self.picture.show_frame(found.frame)
        self.query_one("#calibration-facts", Static).update(self._facts())
        task = (
            Text(visible_lines(found.problem), "bold")
            if found.problem
            else Text(self._instruction())
        )
        self.query_one("#calibration-task", Static).update(task)
        self.refresh_bindings()

    def _instruction(self) -> str:
        found = self.calibrator
        if found.checking:
            return (
                "Each joint sways once, up first. Does the robot move as the picture? Space: off."
            )
        if found.step in TASKS:
            return TASKS[found.step]
        if found.checked:
            return f"The check is over. [ and ] choose a joint that was wrong. Next: {self._after}"
        return "All joints are calibrated. c: let the robot stand, and sway each joint a little."

    def _facts(self) -> Text:
        found = self.calibrator
        joint, reading = found.joints[found.name], found.reading
        text = Text(f"{len(found.done)} of {len(found.names)} calibrated", no_wrap=True)
        for number, (leg, names) in enumerate(found.robot.leg_joints().items()):
            text.append(f"\n{visible(leg)} " if number % 2 == 0 else f"   {visible(leg)} ", "dim")
            for name in names:
                mark = "✓" if name in found.done else "·"
                text.append(mark, "reverse" if name == found.name else "")
        hottest, volts = reading.temperature.max(), reading.volts
        load = 100 * np.abs(reading.load).max()
        rows = {
            "joint": found.name,
            "servo": f"id {joint.id}, {joint.servo}",
            "direction": f"{joint.direction:+d}",
            "angle": f"{found.angle:.1f}°" if math.isfinite(found.angle) else NOTHING,
            "torque": f"on, {load:.0f} %{', blocked' * found.blocked}" if found.on else "off",
            "temperature": f"{hottest:.0f} °C" if math.isfinite(hottest) else "",
            "voltage": f"{volts:.1f} V" if math.isfinite(volts) else "",
        }
        text.append("\n\n")
        for label, value in rows.items():
            text.append(f"{label:<12}", "dim")
            text.append(f"{visible(value)}\n", "bold" if value.startswith("on,") else "")
        text.append("\n")
        at = STEPS.index(found.step) if found.step in STEPS else len(STEPS)
        for number, title in enumerate(TITLES):
            mark = "✓" if number < at else "▸" if number == at else " "
            text.append(f"{mark} {title}\n", "bold" if number == at else "dim")
        return text

    def action_do(self, what: str, *arguments: float) -> None:
        self.calibrator.order(what, *arguments)

    def action_check(self) -> None:
        self.action_do("check")

    def action_view(self) -> None:
        self.picture.action_next_view()

    def action_zoom(self, steps: int) -> None:
        self.picture.action_zoom(steps)

    async def _leave(self) -> None:
        self.app.exit()

    def command_line(self) -> str:
        return self._line

    def obstacle(self, action: str) -> str:
        missing = len(self.calibrator.names) - len(self.calibrator.done)
        if action == "check" and missing:
            return f"{missing} joints are not calibrated yet."
        return super().obstacle(action)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        return action == "back" or super().check_action(action, parameters)
