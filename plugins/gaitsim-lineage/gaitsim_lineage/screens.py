"""Lineage in the terminal UI: its key, and the keys of its screen."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden, Shown, declare

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _show(screen: "GaitScreen") -> None:
    from gaitsim_lineage.line_screen import LineScreen

    if screen.choice is not None and not isinstance(screen, LineScreen):
        screen.app.push_screen(LineScreen(screen.choice.run, screen.choice.which))


LINEAGE = Hidden(
    "lineage",
    "H",
    "Lineage",
    "The ancestors of this individual, and which change brought which gain",
    why="Select a run.",
    on="individual",
    show=_show,
)

declare("lineage", [
    Shown("rise", "l", "Rise", "Go to the next of the largest rises"),
    Shown("replay", "r", "Replay", "Replay this ancestor frame by frame"),
    Shown("fork", "f", "Fork", "Start a new run from this ancestor"),
    Shown("export", "e", "Export", "Export gait files, plots and videos of this ancestor"),
    Hidden("turn", "w", "View", "From the corner, the side, above, or the front")
])  # fmt: skip
