"""A body in the laboratory: its title, the distance that it walks, and its motion."""

from typing import Any

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from gaitsim.render.terminal.text import number, visible_lines
from gaitsim.tui.formatting import clip
from gaitsim.tui.screens.laboratory_loading import Walk
from gaitsim.tui.widgets.canvas import BodyCanvas

FPS = 12  # three bodies move at once
WALKS, LIMPS = 0.9, 0.5  # minimum shares of the intact distance for the first two colours
BAR = 12  # cells of a full bar
FALLEN = "✗ fell"


class WalkPane(Vertical):
    """A walking body.

    Args:
        title: title of the pane.
        message: message shown instead of a body.

    Attributes:
        walk: walk shown; None without one.
        canvas: canvas of the body.
    """

    DEFAULT_CSS = """
    WalkPane {
        width: 1fr; height: 1fr; border-left: solid $border-blurred;
        & > Static { height: 2; padding: 0 1; }
        &:focus-within > Static { background: $surface; }
    }
    """

    def __init__(self, title: str, message: str, **settings: Any) -> None:
        super().__init__(**settings)
        self._pane_title, self._message = title, message
        self.walk: Walk | None = None
        self._share: float | None = None
        self._heading = Static()
        self.canvas = BodyCanvas(message=message, fps=FPS)

    def compose(self) -> ComposeResult:
        yield self._heading
        yield self.canvas

    def on_mount(self) -> None:
        self.canvas.playing = True
        self._title()

    def show(self, walk: Walk, intact: Walk | None, title: str = "") -> None:
        """Show a walk from its beginning, in real time.

        Args:
            walk: walk of the body.
            intact: walk on the intact body, the reference for the share; None for no share.
            title: new title of the pane; '' keeps the title.
        """
        self.walk = walk
        reference = intact.forward if intact is not None else 0.0
        self._share = walk.forward / reference if reference > 0 else None
        self._pane_title = title or self._pane_title
        self.canvas.set_skeleton(walk.individual.skeleton)
        self.canvas.speed, self.canvas.seconds = 1.0, 0.0
        self._title()

    def show_message(self, message: str = "", title: str = "") -> None:
        """Show a message instead of a body; '' for the initial message."""
        self.walk, self._pane_title = None, title or self._pane_title
        self.canvas.set_skeleton(None, visible_lines(message or self._message))
        self._title()

    def on_resize(self) -> None:
        self._title()

    def _title(self) -> None:
        width = max(self.size.width - 3, 8)
        first = Text(clip(self._pane_title, width), "bold", no_wrap=True)
        second = describe_walk(self.walk, self._share, width, self.app.theme_variables)
        self._heading.update(Text("\n").join([first, second]))


def colour_of(share: float) -> str:
    """Return the theme colour of a share of the distance on the intact body."""
    return "success" if share >= WALKS else "warning" if share >= LIMPS else "error"


def describe_walk(
    walk: Walk | None, share: float | None, width: int, colours: dict[str, str]
) -> Text:
    """Return the distance in metres, a bar with its share of the intact one, and any fall."""
    text = Text(no_wrap=True, overflow="ellipsis")
    if walk is None:
        return text
    ink = "foreground" if share is None else colour_of(share)
    text.append(f"{number(walk.forward, 2)} m", f"bold {colours[ink]}")
    if share is not None:
        percent = f" {number(100 * share, 0)} %"
        fallen = len(FALLEN) + 1 if walk.fell is not None else 0
        cells = min(width - text.cell_len - len(percent) - fallen - 1, BAR)
        if cells > 2:
            filled = round(min(max(share, 0.0), 1.0) * cells)
            text.append(" ").append("█" * filled, colours[ink])
            text.append("░" * (cells - filled), "dim")
        text.append(percent, colours[ink])
    if walk.fell is not None:
        text.append(f" {FALLEN}", f"bold {colours['error']}")
        text.append(f" at {walk.fell:.1f} s", colours["error"])
    return text
