"""The style of plots, and functions that write them to files without a display."""

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from gaitsim.choices import PlotFormat
from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import check_folder
from gaitsim.render.colours import (
    LEFT,
    LEFT_COLOUR,
    LEFT_ON_DARK,
    LINES,
    LINES_ON_DARK,
    MIDDLE,
    RIGHT,
    RIGHT_COLOUR,
    RIGHT_ON_DARK,
    sides,
)
from gaitsim.storage.files.atomic import write_bytes, writing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = get_args(PlotFormat)
WIDTH = 3.4  # inches: the column of a journal, 86 mm
RESOLUTION = 300  # dots per inch of a PNG
_UNDATED: dict[str, dict[str, Any]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
# These distinguish lines in greyscale.
STYLES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (1, 1)))


@dataclass(frozen=True)
class Theme:
    """Colours of a plot.

    Attributes:
        name: value of `--theme`.
        background: colour of the background.
        ink: colour of text, axes and single lines.
        faint: colour of grids and shaded areas.
        left, right: colours of left and right feet.
        colours: colours of lines in order, none of which is a colour of feet.
    """

    name: str
    background: str
    ink: str
    faint: str
    left: str
    right: str
    colours: tuple[str, ...]

    def line(self, index: int) -> dict[str, Any]:
        """Return the colour and dashes of a line by its index; the first 35 are distinct."""
        return {
            "color": self.colours[index % len(self.colours)],
            "linestyle": STYLES[index % len(STYLES)],
        }

    def foot_colours(self, names: Sequence[str]) -> list[str]:
        """Return the colours of feet, by the side in their names."""
        of = {LEFT: self.left, RIGHT: self.right, MIDDLE: self.ink}
        return [of[side] for side in sides(tuple(names)).tolist()]


LIGHT = Theme("light", "#FFFFFF", "#1A1A1A", "#C8C8C8", LEFT_COLOUR, RIGHT_COLOUR, LINES)
DARK = Theme("dark", "#15181C", "#E6E6E6", "#4A4F57", LEFT_ON_DARK, RIGHT_ON_DARK, LINES_ON_DARK)
THEMES = {theme.name: theme for theme in (LIGHT, DARK)}


@contextmanager
def styled(theme: Theme) -> Iterator[None]:
    """Apply gaitsim's style, not the user's, to figures created and drawn in the block."""
    from matplotlib import style

    settings = {
        "axes.axisbelow": True,
        "axes.edgecolor": theme.ink,
        "axes.facecolor": theme.background,
        "axes.grid": True,
        "axes.labelcolor": theme.ink,
        "axes.labelsize": 8,
        "axes.linewidth": 0.6,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlelocation": "left",
        "axes.titlesize": 8,
        "figure.constrained_layout.h_pad": 0.03,
        "figure.constrained_layout.w_pad": 0.03,
        "figure.constrained_layout.use": True,
        "figure.facecolor": theme.background,
        "figure.titlesize": 8,
        "font.size": 8,
        "grid.alpha": 0.5,
        "grid.color": theme.faint,
        "grid.linewidth": 0.4,
        "legend.fontsize": 7,
        "legend.frameon": False,
        "lines.linewidth": 1.0,
        "lines.solid_capstyle": "round",
        "lines.dash_capstyle": "butt",  # keep gaps open where lines cross
        "pdf.fonttype": 42,  # journals reject Type 3 fonts
        "savefig.facecolor": theme.background,
        "svg.fonttype": "none",  # keep text searchable and editable
        "svg.hashsalt": "gaitsim",  # otherwise names in the file are random
        "text.color": theme.ink,
        "text.parse_math": False,  # dollar signs in names are not mathematics
        **{f"{axis}tick.{key}": value for axis in "xy" for key, value in _ticks(theme).items()},
    }
    with style.context(settings, after_reset=True):
        yield


def _ticks(theme: Theme) -> dict[str, Any]:
    return {"color": theme.ink, "labelsize": 7, "major.size": 2.5, "major.width": 0.6}


def picture(figure: "Figure", format: str, theme: Theme, resolution: float = RESOLUTION) -> bytes:
    """Return a figure as the content of a file; equal figures give equal bytes.

    Args:
        figure: figure created within `styled(theme)`.
        format: file format, one of `FORMATS`.
        theme: theme of the figure, needed because Matplotlib creates some artists, such as ticks,
            only when it draws.
        resolution: dots per inch of a PNG.
    """
    drawn = io.BytesIO()
    with styled(theme), warnings.catch_warnings():
        # Characters of a name that the font lacks are drawn as boxes.
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font")
        figure.savefig(drawn, format=format, dpi=resolution, metadata=_UNDATED[format])
    return drawn.getvalue()


def save(figure: "Figure", path: Path, theme: Theme = LIGHT) -> None:
    """Write a figure atomically, in the format of the file's suffix."""
    check_target(path)
    format = path.suffix.removeprefix(".").lower()
    write_bytes(path, picture(figure, format, theme))


def replace_figure(path: Path, figure: "Figure | None") -> None:
    """Write a figure; without one, remove an old figure."""
    if figure is not None:
        save(figure, path)
    else:
        with writing(path):
            path.unlink(missing_ok=True)


def check_target(path: Path) -> None:
    """Check the path of a plot before drawing it."""
    if path.suffix.removeprefix(".").lower() not in FORMATS:
        raise GaitsimError(
            f"{path} does not have the extension of a plot format",
            allowed=", ".join(f".{known}" for known in FORMATS),
        )
    check_folder(path)
