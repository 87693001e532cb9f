"""A parallel projection from a corner at one scale, with a grid on the floor."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.plots.style import Theme
from gaitsim.render.ticks import round_step

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

AZIMUTH, ELEVATION = math.radians(-75.0), math.radians(24.0)
# Rows: right and up on paper. The projection is parallel, so that lengths can be compared.
VIEW: Floats = np.array(
    [
        [-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0],
        [
            -math.sin(ELEVATION) * math.cos(AZIMUTH),
            -math.sin(ELEVATION) * math.sin(AZIMUTH),
            math.cos(ELEVATION),
        ],
    ]
)

_FONT_SIZE = 7  # font size, points
# Points between numbers: the horizontal gap, and the vertical distance of their middles.
_LABEL_GAPS = (5.0, 10.0)


def project(points: NDArray[np.floating]) -> Floats:
    """Project points (…, 3) in space to points (…, 2) on the plane of the paper, m."""
    flat: Floats = np.asarray(points, dtype=np.float64) @ VIEW.T
    return flat


def draw_floor(axes: "Axes", low: Floats, high: Floats, scale: float, theme: Theme) -> Floats:
    """Draw a floor under a box, with numbers along its front and its right side.

    Args:
        axes: axes to draw in.
        low: least x, y and z of the box, m.
        high: largest x, y and z of the box, m.
        scale: points on paper per metre, which decides how many numbers fit.
        theme: colours of the plot.

    Returns:
        The corner of the floor with the least x and y, (2,) m, where lines of the grid cross.
    """
    step = round_step(float((high - low).max()) / 9)
    first = np.floor(low[:2] / step - 0.05)
    last = np.ceil(high[:2] / step + 0.05)
    begin, end, z = first * step, last * step, float(low[2])
    for axis in (0, 1):
        for line in range(int(first[axis]), int(last[axis]) + 1):
            ends = np.array([[*begin, z], [*end, z]])
            ends[:, axis] = line * step
            axes.plot(*project(ends).T, color=theme.faint, linewidth=0.5, alpha=0.7, zorder=0)
    # The number at the corner belongs to y.
    across = range(int(first[0]), int(last[0]))
    room = _longest_width(line * step for line in across) + _LABEL_GAPS[0]
    for line in _lines_to_label(across[0], across[-1], room / (step * scale * VIEW[0, 0])):
        at = project(np.array([line * step, begin[1], z]))
        _write(axes, at, f"{line * step:g}", (0, -4.5), ha="center", va="top")
    deep = _lines_to_label(
        int(first[1]), int(last[1]), _LABEL_GAPS[1] / (step * scale * VIEW[1, 1])
    )
    for line in deep:
        at = project(np.array([end[0], line * step, z]))
        _write(axes, at, f"{line * step:g}", (3, -1), ha="left", va="center")
    _write(
        axes,
        project(np.array([(begin[0] + end[0]) / 2, begin[1], z])),
        "x (m)",
        (0, -13),
        ha="center",
        va="top",
    )
    _write(
        axes,
        project(np.array([end[0], (begin[1] + end[1]) / 2, z])),
        "y (m)",
        # The side of the floor leans to the right, and so does the column of its numbers.
        (3 + _longest_width(line * step for line in deep) + 6, -4),
        ha="left",
        va="center",
    )
    return begin


def draw_height_scale(axes: "Axes", foot: Floats, top: float, theme: Theme) -> None:
    """Draw a height scale at a point of the floor, (3,) m, up to `top`, m."""
    step = round_step((top - float(foot[2])) / 5)
    first, last = math.ceil(foot[2] / step - 1e-6), math.ceil(top / step - 1e-6)
    ends = np.array([foot, [*foot[:2], last * step]])
    axes.plot(*project(ends).T, color=theme.ink, linewidth=0.6)
    for line in range(first, last + 1):
        at = project(np.array([*foot[:2], line * step]))
        axes.annotate(
            "",
            (float(at[0]), float(at[1])),
            xytext=(-2.5, 0),
            textcoords="offset points",
            arrowprops={
                "arrowstyle": "-",
                "linewidth": 0.6,
                "color": theme.ink,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
        _write(axes, at, f"{line * step:g}", (-4, 0), ha="right", va="center")
    middle = project(np.array([*foot[:2], (foot[2] + last * step) / 2]))
    aside = 4 + _longest_width(line * step for line in range(first, last + 1)) + 3
    _write(axes, middle, "z (m)", (-aside, 0), ha="right", va="center", rotation=90)


def _lines_to_label(first: int, last: int, least: float) -> range:
    """Return the indices of the lines of a grid to label, at least `least` apart; 0 is included."""
    every = int(round_step(max(1.0, least)))
    return range(math.ceil(first / every) * every, last + 1, every)


def _longest_width(numbers: Iterable[float]) -> float:
    """Return the width of the longest number, in points."""
    from matplotlib.textpath import TextPath

    paths = [
        TextPath((0, 0), f"{number:g}".replace("-", "−"), size=_FONT_SIZE) for number in numbers
    ]
    return max((float(path.get_extents().x1) for path in paths), default=0.0)


def _write(axes: "Axes", at: Floats, text: str, shift: tuple[float, float], **how: Any) -> None:
    axes.annotate(
        text.replace("-", "−"),
        (float(at[0]), float(at[1])),
        xytext=shift,
        textcoords="offset points",
        fontsize=_FONT_SIZE,
        annotation_clip=False,
        **how,
    )
