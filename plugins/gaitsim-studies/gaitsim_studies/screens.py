"""Studies in the terminal UI: the list of studies and comparisons, and its keys."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden, Shown, declare

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _show(screen: "GaitScreen") -> None:
    from gaitsim_studies.studies_screen import Studies

    if not isinstance(screen, Studies):
        screen.app.push_screen(Studies())


def _ask(screen: "GaitScreen") -> None:
    from gaitsim_studies.studies_screen import ask_comparison

    ask_comparison(screen)


STUDIES = Hidden("studies", "u", "Studies", "Sweeps and comparisons over repeats", show=_show)
STATISTICS = Hidden(
    "statistics",
    "ctrl+s",
    "Statistics",
    "Repeat the experiments of these runs, with tests and intervals",
    why="Statistics need two or more runs.",
    on="runs",
    show=_ask,
)

declare("studies", [
    Shown("new", "n", "New study", "Sweep options over ranges", "sweep"),
    Shown("compare", "c", "New comparison", "Compare experiments over repeats"),
    Shown("continue", "g", "Continue", "Run the remaining cells",
          why="Only a stopped study can be continued."),
    Shown("stop", "x", "Stop", "A study keeps finished cells",
          why="The study is not running in this app.")
])  # fmt: skip
declare("results", [
    Shown("files", "f", "Files", "Jump to the files"),
    Shown("copy", "p", "Copy path", "Copy the file's path", "copy_path",
          why="Select a file first; press f to go to the files.")
])  # fmt: skip
declare("study", [
    Shown("cancel", "escape", "Cancel", "Start nothing", "dismiss"),
    Shown("begin", "ctrl+r", "Start", "Start, from any field", "start")
])  # fmt: skip
