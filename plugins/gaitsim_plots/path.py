"""Plot the path of a body in space, with the body drawn at a few moments."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.errors import NothingToPlotError
from gaitsim.individual import Individual
from gaitsim.render.plots.channels import count_trials
from gaitsim.render.plots.data import window_slice
from gaitsim.render.plots.labels import add_heading, heading_of
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.render.scene.themes import mix
from gaitsim.render.ticks import round_step

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Floats = NDArray[np.float64]


_MAX_MOMENTS = 6  # maximum number of moments at which the body is drawn
_MIN_BODY_SIZE = 0.07  # minimum size of a drawn body, as a share of the scene
_MIN_HEIGHT_RATIO = 0.25  # ratio of height to width above which a scene has a height scale

_MIN_EXTENT = 1e-6  # m; anything smaller is a point


@dataclass(frozen=True, eq=False)
class PathScene:
    """The path and the bodies to draw.

    Attributes:
        path: path of the body, (frames, 3) m.
        bodies: segments of the body at each moment, (moments, segments, 2, 3) m.
        at: frames of the moments, (moments,).
        factor: enlargement of the bodies.
    """

    path: Floats
    bodies: Floats
    at: NDArray[np.intp]
    factor: float

    @property
    def planar(self) -> bool:
        """Whether the body is a line along x when seen from above."""
        long, wide = np.ptp(self.bodies[..., :2].reshape(-1, 2), axis=0)
        return bool(wide <= _MIN_EXTENT * long)


def path_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot the path from a corner of the room and from above, at one scale.

    A planar body, which is a line from above, is drawn from the side instead.
    """
    skeleton = individual.skeleton
    part = window_slice(len(skeleton.segments), skeleton.frame_rate, window)
    scene = scene_of(skeleton, part)
    if scene is None:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} cannot be drawn: no frame of its "
            "skeleton is finite",
            where=str(individual.source),
        )
    points = np.concatenate([scene.path, scene.bodies.reshape(-1, 3)])
    low, high = points.min(axis=0), points.max(axis=0)
    if (high - low).max() < _MIN_EXTENT:  # a point that does not move
        low, high = low - 0.05, high + 0.05
    if low[2] > -1e-9 and low[2] < high[2] - low[2]:
        low[2] = 0.0  # include the ground
    with styled(theme):
        figure, space, above, scale = _panels(low, high)
        _draw_corner_view(space, scene, low, high, scale, theme)
        _draw_flat_view(above, scene, (0, 2) if scene.planar else (0, 1), theme)
        # Labels take space and reduce the scale. Redraw with the new scale, which decides how many
        # numbers fit.
        scale = _points_per_metre(figure, space)
        space.clear()
        _draw_corner_view(space, scene, low, high, scale, theme)
        text = heading_of([individual])
        handles, labels = space.get_legend_handles_labels()
        if (trials := count_trials(individual)) > 1:
            labels[0] += f", first of {trials} trials"
        if scene.factor > 1:
            text += f"; body × {scene.factor:g}"
        add_heading(figure, text, handles, labels)
    return figure


def scene_of(skeleton: Skeleton, part: slice) -> PathScene | None:
    """Return the scene of a part of a motion; None if no frame of it is finite.

    The body is drawn at the start, at the end, and in between as often as fits without overlap.
    """
    whole = np.isfinite(skeleton.segments[part]).all(axis=(1, 2, 3))
    whole &= np.isfinite(skeleton.path[part]).all(axis=1)
    if not whole.any():
        return None
    segments = np.asarray(skeleton.segments[part][whole], dtype=np.float64)
    path = np.asarray(skeleton.path[part][whole], dtype=np.float64)
    extent = float(np.ptp(segments[0].reshape(-1, 3), axis=0).max())
    across = float(np.ptp(path, axis=0).max())
    factor = 1.0
    if 0 < extent < _MIN_BODY_SIZE * across:
        factor = round_step(_MIN_BODY_SIZE * across / extent)
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    room = 1.15 * extent * factor
    count = min(_MAX_MOMENTS, 1 + int(across / room)) if room > 0 else 1
    count = max(count, 2 if gone[-1] > 0.05 * extent else 1)
    at = np.searchsorted(gone, np.linspace(0, gone[-1], count) - 1e-12)
    bodies = path[at, None, None] + factor * (segments[at] - path[at, None, None])
    return PathScene(path, bodies, at, factor)


def _panels(low: Floats, high: Floats) -> tuple["Figure", "Axes", "Axes", float]:
    """Create panels for the views from a corner and from above; estimate the points per metre.

    The panels are above each other, or side by side if the motion is tall and slim.
    """
    from matplotlib.figure import Figure

    corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1)
    width, height = np.ptp(project(corners.reshape(-1, 3)), axis=0)
    across, deep = high[:2] - low[:2]
    if height > 2 * width:
        figure = Figure(figsize=(WIDTH, 4.0))
        left, right = figure.subplots(1, 2)
        right.set_aspect("equal", adjustable="box")
        return figure, left, right, 72 * 3.0 / height
    scale = min(2.75 / width, 2.8 / height)
    second = float(np.clip(2.7 * deep / max(across, 1e-9), 0.5, 1.6))
    figure = Figure(figsize=(WIDTH, 1.35 + scale * height + second))
    top, bottom = figure.subplots(2, 1, height_ratios=(scale * height + 0.35, second + 0.2))
    bottom.set_aspect("equal", adjustable="datalim")  # fills the width
    return figure, top, bottom, 72 * scale


def _points_per_metre(figure: "Figure", axes: "Axes") -> float:
    """Return the points on paper per metre, after layout."""
    figure.draw_without_rendering()
    (left, _), (right, _) = axes.transData.transform([(0, 0), (1, 0)])
    return float((right - left) * 72 / figure.dpi)


def _draw_corner_view(
    axes: "Axes", scene: PathScene, low: Floats, high: Floats, scale: float, theme: Theme
) -> None:
    corner = draw_floor(axes, low, high, scale, theme)
    if high[2] - low[2] > _MIN_HEIGHT_RATIO * (high - low)[:2].max():
        draw_height_scale(axes, np.array([*corner, low[2]]), float(high[2]), theme)
    shadow = scene.path.copy()
    shadow[:, 2] = low[2]
    axes.plot(*project(shadow).T, color=theme.faint, linewidth=1.2, zorder=1)
    for frame in scene.at.tolist():
        drop = np.stack([scene.path[frame], shadow[frame]])
        axes.plot(*project(drop).T, color=theme.ink, linewidth=0.4, linestyle=":", zorder=1)
    _draw_bodies(axes, project(scene.bodies), theme)
    _draw_path(axes, project(scene.path), theme)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_flat_view(axes: "Axes", scene: PathScene, shown: tuple[int, int], theme: Theme) -> None:
    """Draw a view along an axis, with the two other axes."""
    _draw_bodies(axes, scene.bodies[..., shown], theme)
    _draw_path(axes, scene.path[:, shown], theme)
    across, up = ("xyz"[axis] for axis in shown)
    axes.set_xlabel(f"{across} (m)")
    axes.set_ylabel(f"{up} (m)")
    axes.set_title("from the side" if up == "z" else "from above", fontsize=7, pad=2)


def _draw_bodies(axes: "Axes", bodies: Floats, theme: Theme) -> None:
    """Draw bodies of shape (moments, segments, 2, 2), later ones darker."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgb

    ink, paper = (np.array(to_rgb(colour)) for colour in (theme.ink, theme.background))
    shares = np.linspace(0.3, 0.9, len(bodies)) if len(bodies) > 1 else [1.0]
    # Colours are mixed, as transparent lines would show a dot wherever two of them meet.
    for body, colour in zip(bodies, mix(paper, ink, shares), strict=True):
        lines = LineCollection([*body], colors=[tuple(colour)], linewidths=0.8, zorder=2)
        lines.set_capstyle("round")
        axes.add_collection(lines)
    axes.autoscale_view()


def _draw_path(axes: "Axes", path: Floats, theme: Theme) -> None:
    """Draw the path (frames, 2) with marks at its start and end."""
    green = theme.colours[0]
    axes.plot(*path.T, color=green, linewidth=1.2, label="path", zorder=3)
    for place, marker, face, name in (
        (path[0], "o", theme.background, "start"),
        (path[-1], "s", green, "end"),
    ):
        axes.plot(
            *place,
            marker=marker,
            linestyle="",
            markersize=4,
            markerfacecolor=face,
            markeredgecolor=green,
            label=name,
            zorder=4,
        )


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
