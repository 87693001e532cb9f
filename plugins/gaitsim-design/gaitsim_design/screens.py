"""Maps of designs in the terminal UI: their key, and the keys of their screen."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden, Shown, declare

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _show(screen: "GaitScreen") -> None:
    from gaitsim_design.map_screen import DesignScreen

    if screen.choice is not None and not isinstance(screen, DesignScreen):
        screen.app.push_screen(DesignScreen(screen.choice.run))


DESIGNS = Hidden(
    "designs",
    "O",
    "Map of designs",
    "The designs of a body, with their figures and intervals",
    why="Select a map of designs; 'gaitsim design' computes one.",
    on="individual",
    show=_show,
)

declare("designs", [
    Shown("colour", "c", "Colour", "Colour the map by the next quantity"),
    Shown("original", "o", "Original", "Select the original"),
    Shown("best", "b", "Best", "Select the design with the best mean score"),
    Shown("axes", "x", "Axes", "Show the next pair of dimensions",
          why="The map has no other dimensions."),
    Shown("replay", "r,enter", "Replay", "Replay this design frame by frame", display="r"),
    Shown("export", "e", "Export", "Export gait files, plots and videos of this design"),
    Hidden("turn", "w", "View", "From the corner, the side, above, or the front")
])  # fmt: skip
