"""Web pages in the terminal UI: the gallery and the playground."""

from typing import TYPE_CHECKING

from gaitsim.screen import Hidden

if TYPE_CHECKING:
    from gaitsim.screen import GaitScreen


def _write_gallery(screen: "GaitScreen") -> None:
    about = "A card for each run, and a page that plays it. An existing gallery is replaced."
    screen.ask_for_file("Folder of the gallery", about, "site", "gallery", screen.gaitsim.folder)


def _write_playground(screen: "GaitScreen") -> None:
    about = "One page, for any browser, on which visitors evolve a spider."
    screen.ask_for_file("File of the page", about, "playground.html", "playground")


GALLERY = Hidden(
    "gallery", "B", "Gallery", "Write a web site of all runs here", show=_write_gallery
)
PLAYGROUND = Hidden(
    "playground",
    "",
    "Playground",
    "Write a web page on which a spider learns to walk",
    show=_write_playground,
)
