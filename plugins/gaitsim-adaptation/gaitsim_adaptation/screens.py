"""The part of adaptation in the terminal UI: the laboratory, and its keys."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden, Shown, declare

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _show(screen: "GaitScreen") -> None:
    from gaitsim_adaptation.laboratory import Laboratory

    if screen.choice is not None:
        screen.app.push_screen(Laboratory(screen.choice.run, screen.choice.which))


LABORATORY = Shown(
    "laboratory",
    "L",
    "Laboratory",
    "Remove legs from the body and adapt its gait",
    why="Select a run with a champion.",
    on="individual",
    show=_show,
)

declare("lab", [
    Shown("joint", "d", "Damage", "Make a joint of the chosen leg stuck, slow or weak"),
    Shown("repair", "i", "Repair", "Remove all damage"),
    Shown("physics", "p", "Physics", "Switch between kinematics and rigid-body physics"),
    Shown("adapt", "a", "Adapt", "Try gaits of the atlas on the damaged body until one walks"),
    Shown("refine", "m", "Refine", "Try small changes of the best gait"),
    Shown("stop", "x", "Stop", "Stop the search and keep its trials"),
    Shown("replay", "r", "Replay",
          "Replay the gait shown on the damaged body, frame by frame"),
    Shown("export", "e", "Export", "Export gait files, plots and videos of the gait shown")
])  # fmt: skip
declare("plan", [
    Hidden("front", "up", "Leg in front", "Choose the leg in front", "choose(1, 0)"),
    Hidden("behind", "down", "Leg behind", "Choose the leg behind", "choose(-1, 0)"),
    Hidden("left", "left", "Leg to the left", "Choose the leg to the left", "choose(0, 1)"),
    Hidden("right", "right", "Leg to the right", "Choose the leg to the right",
           "choose(0, -1)"),
    Shown("remove", "enter,space", "Toggle leg", "Remove or restore the chosen leg")
])  # fmt: skip
