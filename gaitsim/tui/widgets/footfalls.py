"""The footfall diagram, synchronised with a moving body."""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from rich.style import Style
from textual.geometry import Size
from textual.reactive import reactive

from gaitsim.contracts import Skeleton
from gaitsim.render.colours import sides
from gaitsim.render.terminal.footfalls import strip
from gaitsim.render.terminal.member_picture import narrow
from gaitsim.tui.widgets.cells import Cells, Picture

SHARE = 0.36  # maximum share of the terminal's height
TIMED = 30  # minimum rows of a terminal for a time axis below


class FootfallStrip(Cells):
    """The footfall diagram (Hildebrand 1965) around a frame; hidden for a body without feet."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "footfalls--swing",
        "footfalls--moment",
        "footfalls--middle",
        "footfalls--left",
        "footfalls--right",
        "footfalls--time",
    }
    DEFAULT_CSS = """
    FootfallStrip {
        width: 1fr; height: auto;
        & > .footfalls--swing { color: $foreground 25%; }
        & > .footfalls--moment { color: $secondary; }
        & > .footfalls--middle { color: $foreground; }
        & > .footfalls--left { color: $primary; }
        & > .footfalls--right { color: $warning; }
        & > .footfalls--time { color: $foreground 80%; }
    }
    """

    frame: reactive[int] = reactive(0, repaint=False, init=False)

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._rate = 1.0
        self._touching = np.empty((0, 0), dtype=np.bool_)
        self._names: tuple[str, ...] = ()
        self._sides: NDArray[np.intp] = np.empty(0, dtype=np.intp)
        self.set_skeleton(None)

    def set_skeleton(self, skeleton: Skeleton | None) -> None:
        """Show the feet of a body; None hides the diagram."""
        touching = None if skeleton is None else skeleton.touching
        feet = 0 if touching is None else touching.shape[1]
        if skeleton is not None and touching is not None and feet:
            self._rate = skeleton.frame_rate
            self._touching = np.asarray(touching, dtype=np.bool_)
            self._names = tuple(map(narrow, skeleton.contact_names or map(str, range(1, feet + 1))))
            self._sides = sides(skeleton.contact_names or ("",) * feet)
        else:
            self._touching = np.empty((0, 0), dtype=np.bool_)
        self.display = self.feet > 0
        self.refresh(layout=True)
        self.redraw()

    @property
    def feet(self) -> int:
        """The number of feet."""
        return self._touching.shape[1]

    def watch_frame(self) -> None:
        self.redraw()

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return a row per foot, or per two feet if space is short, and one for the time."""
        most = max(int(SHARE * viewport.height), 2)
        rows = min(self.feet if self.feet <= most else -(-self.feet // 2), most)
        return rows + (self.feet <= most and viewport.height >= TIMED)

    def picture(self, columns: int, rows: int) -> Picture:
        return strip(
            self._touching, self._names, self._sides, self.frame, self._rate, columns, rows
        )

    def ink_styles(self) -> list[Style]:
        """Return the styles of swing, the current frame, bars by side, and the time."""
        parts = ("swing", "moment", "middle", "left", "right", "time")
        return [self.ink_style(), *(self.ink_style(f"footfalls--{part}") for part in parts)]
