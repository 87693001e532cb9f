"""Real robots in the terminal UI: their commands, and the keys of the calibration."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden, Shown, declare

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _ask(screen: "GaitScreen") -> None:
    if screen.choice is not None:
        screen.ask_export(screen.choice, "Robot")


ROBOT = Hidden(
    "drive",
    "W",
    "Real robot",
    "Drive your real robot with this gait, or calibrate it",
    why="Select a run with a champion.",
    on="individual",
    show=_ask,
)

declare("calibration", [
    Shown("off", "space", "Off", "Switch the servos off", "do('off')", priority=True),
    Shown("accept", "enter", "Accept", "Answer the question, and go to the next one",
          "do('accept')"),
    Hidden("up", "up", "Up", "Turn the joint up by 5°", "do('jog', 5.0)"),
    Hidden("down", "down", "Down", "Turn the joint down by 5°", "do('jog', -5.0)"),
    Hidden("up-a-little", "right", "Up a little", "Turn the joint up by 0.5°",
           "do('jog', 0.5)"),
    Hidden("down-a-little", "left", "Down a little", "Turn the joint down by 0.5°",
           "do('jog', -0.5)"),
    Shown("flip", "d", "Direction", "The servo turns the other way", "do('flip')"),
    Shown("other", "n", "Next id", "Try the next servo for this joint", "do('other')"),
    Shown("keep", "k", "Keep", "Take both ends of the joint from the model", "do('keep')"),
    Shown("again", "b,backspace", "Previous", "Return to the question before", "do('back')"),
    Shown("joint-back", "left_square_bracket", "Joint", "Previous joint", "do('turn_to', -1)"),
    Shown("joint-on", "right_square_bracket", "Joint", "Next joint", "do('turn_to', 1)"),
    Shown("check", "c", "Check", "Let the robot stand, and sway each joint a little",
          why="Some joints are not calibrated yet."),
    Hidden("view", "v", "View", "From the corner, the side, above, or the front"),
    Hidden("closer", "plus,equals_sign", "Closer", "Zoom in", "zoom(1)"),
    Hidden("farther", "minus", "Farther", "Zoom out", "zoom(-1)")
])  # fmt: skip
