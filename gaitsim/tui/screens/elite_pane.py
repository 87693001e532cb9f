"""A member of an archive in motion: gait name, body, measures and footfalls."""

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.containers import Vertical

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.screens.atlas_source import Elite
from gaitsim.tui.screens.replay_pane import number_lines
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.lines import Lines

FPS = 12
HIGH = 32  # minimum rows for all measures; with fewer rows, FEW are shown
FEW = 3
REASON = 3  # maximum lines of the reason for the gait's name


class ElitePane(Vertical):
    """A member of an archive in motion.

    Attributes:
        canvas: canvas of its body.
        elite: the member; None before the first one, or if it cannot be drawn.
    """

    DEFAULT_CSS = """
    ElitePane {
        width: 4fr; height: 1fr; border-left: solid $border-blurred;
        & > Lines, & > FootfallStrip { padding: 0 1; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self.canvas = BodyCanvas(message="no gait yet", fps=FPS)
        self.elite: Elite | None = None
        self._gait, self._measures, self._feet = Lines(), Lines(), FootfallStrip()

    def compose(self) -> ComposeResult:
        yield self._gait
        yield self.canvas
        yield self._measures
        yield self._feet

    def on_mount(self) -> None:
        self.canvas.playing = True

    def show(self, elite: Elite) -> None:
        """Show a member."""
        if elite is self.elite:
            return
        self.elite = elite
        skeleton = elite.shown.individual.skeleton
        self.canvas.set_skeleton(skeleton)
        self._feet.set_skeleton(skeleton)
        self._feet.frame = self.canvas.frame
        self._list(elite)

    def show_error(self, error: GaitsimError) -> None:
        """Show an error instead of the body."""
        self.elite = None
        self.canvas.set_skeleton(None, visible_lines(str(error)))
        self._feet.set_skeleton(None)
        for lines in (self._gait, self._measures):
            lines.show([])

    def _list(self, elite: Elite) -> None:
        """Show the gait's name and as many measures as fit."""
        width, high = max(self.content_size.width - 2, 16), self.size.height >= HIGH
        lines = []
        if elite.gait is not None:
            name = "no named gait" if elite.gait.name == "none" else elite.gait.name
            reason = Text(visible(elite.gait.reason), "dim", end="")
            lines = [Text(visible(name), "bold", end="")]
            lines += reason.wrap(self.app.console, width)[:REASON]
        self._gait.show(lines)
        measured = elite.shown.measurements.items()
        rows = [(name, one.value, one.unit) for name, one in measured]
        numbers = [*number_lines(rows, width)] if rows else []
        shown = numbers if high else numbers[:FEW]
        self._measures.show([Text(line, no_wrap=True, end="") for line in shown])

    @on(BodyCanvas.Moved)
    def _moved(self) -> None:
        self._feet.frame = self.canvas.frame

    def on_resize(self) -> None:
        if self.elite is not None:
            self._list(self.elite)
