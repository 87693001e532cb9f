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


STUDIES = Hidden(
    "studies",
    "u",
    "Studies",
    "Sweeps and comparisons over repeats",
    words="sweep compare statistics repeats operators table surface report",
    show=_show,
)
STATISTICS = Hidden(
    "statistics",
    "ctrl+s",
    "Statistics",
    "Repeat the experiments of these runs, with tests and intervals",
    words="repeats test significance interval effect size compare experiments",
    why="Statistics need two or more runs.",
    where="At home, with marked runs, or on the comparison screen:",
    on="runs",
    show=_ask,
)

declare("studies", [
    Shown("new", "n", "New study", "Sweep options over ranges", "sweep",
          words="sweep begin start create"),
    Shown("compare", "c", "New comparison", "Compare experiments over repeats",
          words="statistics test begin start create"),
    Shown("continue", "g", "Continue", "Run the remaining cells", words="resume go",
          why="Only a stopped study can be continued."),
    Shown("stop", "x", "Stop", "A study keeps finished cells", words="end kill",
          why="The study is not running in this app.")
])  # fmt: skip
declare("results", [
    Shown("files", "f", "Files", "Jump to the files",
          words="figure surface report table open"),
    Shown("copy", "p", "Copy path", "Copy the file's path", "copy_path", words="clipboard",
          why="Select a file first; press f to go to the files.")
])  # fmt: skip
declare("study", [
    Shown("cancel", "escape", "Cancel", "Start nothing", "dismiss"),
    Shown("begin", "ctrl+r", "Start", "Start, from any field", "start")
])  # fmt: skip
